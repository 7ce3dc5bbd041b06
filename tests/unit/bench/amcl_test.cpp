#include "bench/rivals/amcl.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/src/search/map_index.hpp"
#include "support/matchers.hpp"
#include "tests/unit/bench/mapped_offices.hpp"

namespace cornerfix::bench {
namespace {

/// Few particles, found without walks: the tests' map is small, and so should their time be.
constexpr AmclParams kFew{.max_particles = 4'000, .kld_err = 0.05, .linear_resampling = false};

Amcl make_amcl(const AmclParams& params) {
  const LocalizationMapPtr& map = testing::office_map();
  return {map->grid(), map->index().field, params};
}

TEST(Amcl, FollowsARobotFromAKnownStart) {
  Amcl amcl = make_amcl(kFew);
  const auto moments = testing::office_drive(1);
  amcl.set_pose(moments.front().T_map_base_link);
  RivalAnswer answer;
  for (const auto& moment : moments) answer = amcl.process(moment.scan);
  ASSERT_TRUE(answer.T_map_base_link);
  EXPECT_THAT(*answer.T_map_base_link,
              cornerfix::testing::IsPoseNear(moments.back().T_map_base_link, 0.2, 0.1));
}

TEST(Amcl, FindsARobotThatDrivesThroughTheOffices) {
  Amcl amcl = make_amcl(kFew);
  const auto moments = testing::office_drive(2);
  RivalAnswer answer;
  for (const auto& moment : moments) answer = amcl.process(moment.scan);
  ASSERT_TRUE(answer.T_map_base_link);
  EXPECT_THAT(*answer.T_map_base_link,
              cornerfix::testing::IsPoseNear(moments.back().T_map_base_link, 0.3, 0.1));
}

TEST(Amcl, SaysNothingAtTheFirstScan) {
  Amcl amcl = make_amcl(kFew);
  EXPECT_FALSE(amcl.process(testing::office_drive(1).front().scan).T_map_base_link);
}

TEST(Amcl, WaitsWhileTheRobotStands) {
  Amcl amcl = make_amcl(kFew);
  const RobotScan scan = testing::office_drive(1).front().scan;
  EXPECT_TRUE(amcl.process(scan).updated);
  EXPECT_FALSE(amcl.process(scan).updated);
}

TEST(Amcl, NeedsFewerParticlesOnceTheyLieTogether) {
  Amcl amcl = make_amcl(kFew);
  const auto moments = testing::office_drive(1);
  EXPECT_EQ(amcl.particle_count(), kFew.max_particles);
  amcl.set_pose(moments.front().T_map_base_link);
  for (const auto& moment : moments) (void)amcl.process(moment.scan);
  EXPECT_LT(amcl.particle_count(), kFew.max_particles * 9 / 10);
}

TEST(Amcl, KeepsAllParticlesIfTheMinimumIsTheMaximum) {
  Amcl amcl =
      make_amcl({.min_particles = 3'000, .max_particles = 3'000, .linear_resampling = false});
  const auto moments = testing::office_drive(1);
  amcl.set_pose(moments.front().T_map_base_link);
  for (const auto& moment : moments) (void)amcl.process(moment.scan);
  EXPECT_EQ(amcl.particle_count(), 3'000U);
}

TEST(Amcl, DrawsTheSameParticlesHoweverItLooksThemUp) {
  AmclParams params{.max_particles = 500};
  Amcl linear = make_amcl(params);
  params.linear_resampling = false;
  Amcl binary = make_amcl(params);
  for (const auto& moment : testing::office_drive(1)) {
    (void)linear.process(moment.scan);
    (void)binary.process(moment.scan);
  }
  EXPECT_EQ(linear.heaviest_cluster().mean, binary.heaviest_cluster().mean);
}

TEST(Amcl, SaysNothingWithoutOdometry) {
  Amcl amcl = make_amcl(kFew);
  RobotScan scan = testing::office_drive(1).front().scan;
  scan.T_odom_base_link.reset();
  EXPECT_FALSE(amcl.process(scan).updated);
}

}  // namespace
}  // namespace cornerfix::bench
