/// \file  The services on a database of their own, without a socket and without a clock.
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/localization_service.hpp"
#include "server/map_library.hpp"
#include "server/store_access.hpp"
#include "support/room_drive.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::server {

inline const std::string kNow = "2024-05-01T12:00:00Z";

struct SessionLimits {
  std::size_t max_bytes = std::size_t{1} << 30U;
  std::size_t max_per_robot = 100;
  NowText expired_before{};
  std::size_t max_searched_map_bytes = std::size_t{4} << 30U;
  NowText stale_before{};
  std::size_t max_all = 100;
  std::chrono::milliseconds checkpoint_interval{0};
  std::size_t max_maps_without_ranking = 4;
};

/// What one process would hold. Several may share a file.
struct Process {
  explicit Process(const std::filesystem::path& file, MapLibraryLimits limits = {},
                   const SessionLimits& session_limits = {})
      : stores(StoreAccess::open(file).value()),
        maps(std::make_shared<MapLibrary>(stores, limits, [] { return kNow; })),
        ranking(std::make_shared<MapRanking>(
            stores, maps,
            MapRankingSettings{.quiet_time = std::chrono::seconds(0), .has_thread = false})),
        localization(stores, maps,
                     {.render = render,
                      .now = [] { return kNow; },
                      .clock_ms = {},
                      .on_batch =
                          [this](const BatchOrigin&, const BatchEvents& batch, const auto&) {
                            const std::lock_guard lock(events_mutex);
                            events.scans += batch.scans;
                            events.fixes += batch.fixes;
                            events.lost += batch.lost;
                            events.status = batch.status;
                            for (const double time : batch.times_to_localization_s)
                              events.times_to_localization_s.push_back(time);
                          },
                      .max_session_bytes = session_limits.max_bytes,
                      .max_sessions = session_limits.max_all,
                      .max_sessions_per_robot = session_limits.max_per_robot,
                      .max_searched_map_bytes = session_limits.max_searched_map_bytes,
                      .max_maps_without_ranking = session_limits.max_maps_without_ranking,
                      .expired_before = session_limits.expired_before,
                      .stale_before = session_limits.stale_before,
                      .checkpoint_interval = session_limits.checkpoint_interval},
                     ranking) {}

  /// Enough to distinguish answers.
  static std::string render(const AnswerToRender& answer) {
    std::string text(answer.session);
    text += " " + std::to_string(answer.sequence.value_or(99)) + " " +
            std::string(to_string(answer.answer.status));
    if (answer.answer.searched_maps > 4)
      text += " of " + std::to_string(answer.answer.searched_maps);
    if (answer.answer.pose) {
      const Pose2& pose = answer.answer.pose->T_map_base_link;
      text += " in " + answer.answer.pose->map->name() + " at " + std::to_string(pose.x) + " " +
              std::to_string(pose.y) + " " + std::to_string(pose.yaw);
    }
    return text;
  }

  std::shared_ptr<StoreAccess> stores;
  std::shared_ptr<MapLibrary> maps;
  std::shared_ptr<MapRanking> ranking;
  std::mutex events_mutex;  ///< Batches of several sessions come at once.
  BatchEvents events;
  LocalizationService localization;
};

class ServiceTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file() const { return directory_ / "test.db"; }

  /// A map of figure7_room().
  static void make_map(Process& process, const std::string& name) {
    ASSERT_TRUE(process.maps->put(name, {}));
    const auto drive = testing::mapping_drive();
    ASSERT_TRUE(process.maps->grow(name, drive));
  }

  testing::TemporaryDirectory directory_;
};

}  // namespace cornerfix::server
