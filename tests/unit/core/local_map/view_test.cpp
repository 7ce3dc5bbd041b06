#include "core/src/local_map/view.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cornerfix/corners.hpp>

#include "support/floor_plans.hpp"
#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPointNear;

/// Two scans of the offices.
Submap seen_offices() {
  Submap submap;
  for (const Pose2& pose : {Pose2{0.0, 0.0, 0.0}, Pose2{1.0, 0.0, 0.3}}) {
    const LaserScan scan =
        testing::simulate_scan(testing::offices(), {.beams = 360}, Pose2{1.0, 1.0, 0.0} * pose);
    submap.keep({0, scan, {}, pose}, extract_corners(scan, CornerExtractor::kLineIntersection));
  }
  return submap;
}

TEST(View, IsTheSubmapInBaseLink) {
  const Submap submap = seen_offices();
  const Pose2 T_submap_base_link{1.0, 0.5, 0.9};
  const View view = view_from(submap, T_submap_base_link);
  ASSERT_FALSE(view.evidence.ends.empty());
  ASSERT_EQ(view.evidence.ends.size(), submap.evidence().ends.size());
  for (std::size_t i = 0; i < view.evidence.ends.size(); ++i)
    EXPECT_THAT(T_submap_base_link * view.evidence.ends[i],
                IsPointNear(submap.evidence().ends[i], 1e-9));
  ASSERT_FALSE(view.corners.empty());
  ASSERT_EQ(view.corners.size(), submap.features().size());
  EXPECT_THAT(T_submap_base_link * view.corners[0].position,
              IsPointNear(submap.features()[0].position, 1e-9));
  ASSERT_EQ(view.way.size(), 2U);
  EXPECT_THAT(T_submap_base_link * view.way[1], IsPointNear(Point2(1.0, 0.0), 1e-9));
}

TEST(View, MirroredSwapsLeftAndRight) {
  const View view = view_from(seen_offices(), {});
  const View image = mirrored(view);
  ASSERT_EQ(image.evidence.ends.size(), view.evidence.ends.size());
  for (std::size_t i = 0; i < view.evidence.ends.size(); ++i) {
    EXPECT_EQ(image.evidence.ends[i].x(), view.evidence.ends[i].x());
    EXPECT_EQ(image.evidence.ends[i].y(), -view.evidence.ends[i].y());
  }
  EXPECT_TRUE(image.corners.empty());
}

}  // namespace
}  // namespace cornerfix
