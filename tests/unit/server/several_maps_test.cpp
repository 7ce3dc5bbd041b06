#include "server/localization_service.hpp"

#include <gmock/gmock.h>

#include "unit/server/localization_service_fixture.hpp"

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;

class SeveralMaps : public LocalizationServiceTest {
 protected:
  static constexpr std::size_t kBatches = 20;  // Enough new ground to confirm the pose.

  SeveralMaps() { drive_ = testing::robot_drive(3 * kBatches + 6); }

  void SetUp() override {
    ASSERT_TRUE(process_.maps->put("lab", {}));
    ASSERT_TRUE(process_.maps->grow("lab", drive_in_lab()));
  }

  /// In a room of the same form, but much larger.
  static std::vector<PosedScan> drive_in_lab(double first_stamp = 100.0) {
    constexpr float kScale = 1.7F;
    auto drive = testing::mapping_drive(first_stamp);
    for (PosedScan& scan : drive) {
      for (float& range : scan.scan.ranges) range *= kScale;
      scan.T_map_base_link.x *= kScale;
      scan.T_map_base_link.y *= kScale;
    }
    return drive;
  }

  /// A session in any map whose pose is confirmed: one room has too little new ground for that.
  std::string confirmed_session(Process& process) {
    const std::string id = create(process, {});
    for (std::size_t i = 0; i < kBatches; ++i) answer(process, id, batch(i));
    const auto stored = process.stores->with_sessions([&](storage::SessionStore& sessions) {
      storage::SessionRecord record = sessions.find(id).value().value();
      record.state.confirmed = true;
      return sessions.update(id, {.previous_sequence = record.expected_sequence,
                                  .expected_sequence = record.expected_sequence,
                                  .last_answer = record.last_answer,
                                  .state = &record.state});
    });
    EXPECT_TRUE(stored);
    return id;
  }
};

TEST_F(SeveralMaps, OnlyTheTrackedOneIsLoadedAfterARestart) {
  const std::string id = confirmed_session(process_);
  Process restarted(file());
  EXPECT_THAT(answer(restarted, id, batch(kBatches)), HasSubstr("in office"));
  EXPECT_EQ(restarted.maps->cache_use().loads, 1U);
}

TEST_F(SeveralMaps, OnlyTheOneThatChangedIsLoadedAgain) {
  Process process(file(), {.max_map_bytes = 1});
  const std::string id = create(process, {});
  answer(process, id, batch(0));
  EXPECT_EQ(process.maps->cache_use().loads, 2U);
  ASSERT_TRUE(process.maps->put("lab", {"another text", {}, {}}));
  answer(process, id, batch(1));
  EXPECT_EQ(process.maps->cache_use().loads, 2U);
  ASSERT_TRUE(process.maps->grow("lab", drive_in_lab(900.0)));
  answer(process, id, batch(2));
  EXPECT_EQ(process.maps->cache_use().loads, 3U);
}

TEST_F(SeveralMaps, AreNotSearchedTogetherWhenTheyAreTooLarge) {
  Process process(file(), {}, {.max_searched_map_bytes = 1});
  const std::string id = create(process, {});
  for (int i = 0; i < 2; ++i) {
    const auto refused = process.localization.post_scans(id, batch(0));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
    EXPECT_THAT(refused.error().message, HasSubstr("max_searched_map_bytes"));
  }
  EXPECT_EQ(process.maps->cache_use().loads, 1U);  // The second time it is known before.
  EXPECT_THAT(answer(process, create(process), batch(0)), HasSubstr(" 0 "));
}

}  // namespace
}  // namespace cornerfix::server
