/// \file  A map that MapLibrary changes or makes ready, and how a change is tried again. For the
/// sources of MapLibrary.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include <cornerfix/slam.hpp>

#include "server/map_library.hpp"
#include "server/seen_area.hpp"

namespace cornerfix::server {

/// A map being changed or made ready, one thread at a time.
struct MapLibrary::GrowingMap {
  explicit GrowingMap(std::int64_t id) : map_id(id) {}

  const std::int64_t map_id;
  std::mutex mutex;
  std::optional<Mapper> mapper;           ///< Holds the keyframes of `revision`.
  SeenArea seen;                          ///< By these keyframes.
  std::optional<LidarOdometry> odometry;  ///< At the last scan of a run without poses.
  std::uint64_t revision = 0;

  [[nodiscard]] bool holds(const storage::MapInfo& info) const {
    return mapper.has_value() && revision == info.revision;
  }

  /// What is known of the map in memory may be ahead of the store, or behind it.
  void forget() {
    mapper.reset();
    odometry.reset();
  }
};

[[nodiscard]] inline MapperParams mapper_params(const storage::MapInfo& info) {
  return api::mapper_params_from_json(info.parameters_json);
}

/// What the keyframes show; the drift of a run without poses is taken away first, with calls of
/// `progress`.
[[nodiscard]] Result<MapContent> content_of(const Mapper& mapper, const MapperParams& params,
                                            bool drifts, const MapLibrary::Progress& progress);

/// As storage::check_known(), for a map that may be any.
[[nodiscard]] inline Result<void> check_expected(const storage::MapInfo& map,
                                                 const ExpectedMap& expected) {
  return expected ? storage::check_known(map, *expected) : Result<void>();
}

[[nodiscard]] inline storage::KnownMap known(const storage::MapInfo& map) {
  return {.revision = map.revision, .id = map.id};
}

/// Whether another process came in between, so that trying again on its result makes sense.
/// Not when the map is of the wrong kind: that will not change.
[[nodiscard]] inline bool is_worth_another_try(const Error& error) {
  return error.code == ErrorCode::kConflict && error.field != "map";
}

template <typename Change>
auto retrying(Change change) {
  constexpr int kMaxRevisionAttempts = 3;
  for (int attempt = 1;; ++attempt) {
    auto result = change();
    if (result || attempt == kMaxRevisionAttempts || !is_worth_another_try(result.error()))
      return result;
  }
}

/// An error in a part of the request.
[[nodiscard]] inline Error at_part(Error error) {
  error.field = "/" + error.field;
  return error;
}

}  // namespace cornerfix::server
