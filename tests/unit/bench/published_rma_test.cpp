#include "bench/rivals/published_rma.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/matchers.hpp"
#include "tests/unit/bench/mapped_offices.hpp"

namespace cornerfix::bench {
namespace {

LocalizationMapPtr vfp_map_of(const cornerfix::testing::SceneBuilder& scene, const Point2& inside) {
  MapperParams params;
  params.extractor = CornerExtractor::kVfp;
  Mapper mapper(params);
  for (const PosedScan& scan : cornerfix::testing::mapping_scans(scene, inside)) mapper.add(scan);
  return std::make_shared<const LocalizationMap>("map", 1, mapper.build());
}

TEST(PublishedRma, FindsAndFollowsARobotInARoomLikeNoOther) {
  const auto room = cornerfix::testing::random_room(3);
  PublishedRma rma(vfp_map_of(room, {0, 0}), {.min_votes = 5, .sampling = {.overlap = 0.3}});
  const cornerfix::testing::Robot robot{.lidar = {.beams = 720, .noise_m = 0.005}};
  const auto poses = cornerfix::testing::wander(room, {0.0, 0.0, 0.4}, 40);
  const auto moments = cornerfix::testing::drive(room, robot, poses, 1);
  RivalAnswer answer;
  for (const auto& moment : moments) answer = rma.process(moment.scan);
  ASSERT_TRUE(answer.T_map_base_link);
  EXPECT_THAT(*answer.T_map_base_link,
              cornerfix::testing::IsPoseNear(moments.back().T_map_base_link, 0.1, 0.05));
}

TEST(PublishedRma, SaysNothingWhereNoMatchHasTheVotes) {
  PublishedRma rma(vfp_map_of(cornerfix::testing::random_room(3), {0, 0}), {.min_votes = 1000});
  for (const auto& moment : testing::office_drive(1))
    EXPECT_FALSE(rma.process(moment.scan).T_map_base_link);
}

}  // namespace
}  // namespace cornerfix::bench
