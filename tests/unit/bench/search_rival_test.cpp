#include "bench/rivals/search_rival.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/src/search/map_index.hpp"
#include "support/matchers.hpp"
#include "tests/unit/bench/mapped_offices.hpp"

namespace cornerfix::bench {
namespace {

TEST(SearchRival, FollowsTheRobotFromWhereTheSearchFoundIt) {
  const auto moments = testing::office_drive(1);
  SearchRival rival([&](std::span<const Point2>) { return moments.front().T_map_base_link; },
                    testing::office_map()->index().field);
  for (const auto& moment : moments) {
    const RivalAnswer answer = rival.process(moment.scan);
    ASSERT_TRUE(answer.T_map_base_link);
    ASSERT_THAT(*answer.T_map_base_link,
                cornerfix::testing::IsPoseNear(moment.T_map_base_link, 0.15, 0.06));
  }
}

TEST(SearchRival, SearchesAgainOnlyOnceTheRobotHasMoved) {
  int searches = 0;
  SearchRival rival(
      [&](std::span<const Point2>) {
        ++searches;
        return std::nullopt;
      },
      testing::office_map()->index().field);
  RobotScan scan = testing::office_drive(1).front().scan;
  EXPECT_TRUE(rival.process(scan).updated);
  EXPECT_FALSE(rival.process(scan).updated);
  scan.T_odom_base_link = *scan.T_odom_base_link * Pose2{0.25, 0.0, 0.0};
  EXPECT_TRUE(rival.process(scan).updated);
  EXPECT_EQ(searches, 2);
}

}  // namespace
}  // namespace cornerfix::bench
