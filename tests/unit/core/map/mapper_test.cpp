#include <cornerfix/mapper.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "support/floor_plans.hpp"
#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPointNear;

using std::numbers::pi;

std::vector<PosedScan> room_scans() {
  return testing::mapping_scans(testing::figure7_room(), {6.0, 5.0});
}

PosedScan scan_at(const Pose2& pose) {
  return {testing::simulate_scan(testing::figure7_room(), {.beams = 360}, pose), {}, pose};
}

Mapper mapper_of(const std::vector<PosedScan>& scans, const MapperParams& params = {}) {
  Mapper mapper(params);
  for (const PosedScan& scan : scans) mapper.add(scan);
  return mapper;
}

std::vector<std::array<double, 5>> numbers(const std::vector<Feature>& features) {
  std::vector<std::array<double, 5>> result;
  for (const Feature& f : features) {
    result.push_back(
        {f.position.x(), f.position.y(), f.turn_angle, f.bisector, static_cast<double>(f.count)});
  }
  return result;
}

void expect_same(const MapContent& actual, const MapContent& expected) {
  EXPECT_EQ(numbers(actual.features), numbers(expected.features));
  EXPECT_EQ(actual.descriptors.offsets, expected.descriptors.offsets);
  EXPECT_EQ(actual.descriptors.entries, expected.descriptors.entries);
  EXPECT_EQ(actual.grid, expected.grid);
}

TEST(Mapper, TheFirstScanIsAKeyFrame) { EXPECT_TRUE(Mapper().is_key_frame(scan_at({6, 5, 0}))); }

TEST(Mapper, AScanFarEnoughFromTheLastKeyFrameIsOne) {
  Mapper mapper({.key_frame_distance_m = 0.5, .key_frame_angle_rad = 0.3});
  mapper.add(scan_at({6.0, 5.0, 3.1}));
  EXPECT_FALSE(mapper.is_key_frame(scan_at({6.0, 5.0, 3.1})));
  EXPECT_FALSE(mapper.is_key_frame(scan_at({6.3, 5.3, 3.1})));
  EXPECT_TRUE(mapper.is_key_frame(scan_at({6.4, 5.4, 3.1})));
  EXPECT_FALSE(mapper.is_key_frame(scan_at({6.0, 5.0, -3.0})));  // across the angle seam
  EXPECT_TRUE(mapper.is_key_frame(scan_at({6.0, 5.0, -2.8})));
}

TEST(Mapper, WithoutLimitsEveryScanIsAKeyFrame) {
  Mapper mapper({.key_frame_distance_m = 0.0});
  mapper.add(scan_at({6, 5, 0}));
  EXPECT_TRUE(mapper.is_key_frame(scan_at({6, 5, 0})));
}

TEST(Mapper, KeepsItsKeyFrames) {
  const std::vector<PosedScan> scans = room_scans();
  const Mapper mapper = mapper_of(scans);
  ASSERT_EQ(mapper.key_frames().size(), scans.size());
  EXPECT_EQ(mapper.key_frames()[3].T_map_base_link, scans[3].T_map_base_link);
  EXPECT_EQ(mapper.key_frames()[3].scan.ranges.size(), scans[3].scan.ranges.size());
}

TEST(Mapper, FindsTheCornersOfTheRoom) {
  const MapContent content = mapper_of(room_scans()).build();
  const testing::SceneBuilder room = testing::figure7_room();
  int found = 0;
  const std::vector<Point2> corners = room.corners_seen({7.5, 5.0}, 0.7);
  for (const Point2& corner : corners) {
    for (const Feature& feature : content.features) {
      if ((feature.position - corner).norm() > 0.25) continue;
      ++found;
      break;
    }
  }
  EXPECT_GE(found, static_cast<int>(corners.size()) - 1);
  EXPECT_EQ(content.descriptors.size(), content.features.size());
}

TEST(Mapper, FeaturesMustBeSeenByEnoughKeyFrames) {
  const std::vector<PosedScan> scans = room_scans();
  const MapContent few = mapper_of(scans, {.min_feature_count = 5}).build();
  const MapContent all = mapper_of(scans, {.min_feature_count = 1}).build();
  EXPECT_LT(few.features.size(), all.features.size());
  EXPECT_FALSE(few.features.empty());
  for (const Feature& feature : few.features) EXPECT_GE(feature.count, 5);
}

TEST(Mapper, CountsTheFeaturesItWillBuild) {
  const Mapper mapper = mapper_of(room_scans());
  EXPECT_EQ(mapper.feature_count(), mapper.build().features.size());
}

TEST(Mapper, TheSameKeyFramesMakeTheSameMap) {
  const std::vector<PosedScan> scans = room_scans();
  expect_same(mapper_of(scans).build(), mapper_of(scans).build());
  const Mapper mapper = mapper_of(scans);
  expect_same(mapper.build(), mapper.build());
}

/// An optimised trajectory moves the keyframes: the map made anew is that of a run that was
/// there.
TEST(Mapper, MovedKeyFramesMakeTheMapOfThatDrive) {
  std::vector<PosedScan> bent = room_scans();
  const std::vector<PosedScan> straight = bent;
  for (std::size_t i = 0; i < bent.size(); ++i) {
    bent[i].T_map_base_link = bent[i].T_map_base_link * Pose2{0.02 * static_cast<double>(i), 0, 0};
  }
  std::vector<PosedScan> optimised = mapper_of(bent).key_frames();
  for (std::size_t i = 0; i < optimised.size(); ++i) {
    optimised[i].T_map_base_link = straight[i].T_map_base_link;
  }
  expect_same(mapper_of(optimised).build(), mapper_of(straight).build());
}

TEST(Mapper, MovingTheDriveMovesTheFeatures) {
  const Pose2 T{-20.0, 7.0, 2.0};
  std::vector<PosedScan> scans = room_scans();
  const MapContent here = mapper_of(scans).build();
  for (PosedScan& scan : scans) scan.T_map_base_link = T * scan.T_map_base_link;
  const MapContent there = mapper_of(scans).build();
  ASSERT_EQ(there.features.size(), here.features.size());
  for (std::size_t i = 0; i < here.features.size(); ++i) {
    EXPECT_THAT(there.features[i].position, IsPointNear(T * here.features[i].position, 1e-6));
  }
}

TEST(Mapper, KnowsWhereTheLaserIsMounted) {
  const Pose2 T_base_link_laser{0.4, 0.2, pi / 2.0};
  std::vector<PosedScan> scans = room_scans();
  const MapContent direct = mapper_of(scans).build();
  for (PosedScan& scan : scans) {
    scan.T_base_link_laser = T_base_link_laser;
    scan.T_map_base_link = scan.T_map_base_link * inverse(T_base_link_laser);
  }
  const MapContent mounted = mapper_of(scans).build();
  ASSERT_EQ(mounted.features.size(), direct.features.size());
  for (std::size_t i = 0; i < direct.features.size(); ++i) {
    EXPECT_THAT(mounted.features[i].position, IsPointNear(direct.features[i].position, 1e-6));
  }
}

TEST(Mapper, HasNoBoundsBeforeTheFirstKeyFrame) {
  EXPECT_FALSE(Mapper().bounds().has_value());
  EXPECT_EQ(Mapper().feature_count(), 0U);
  EXPECT_TRUE(Mapper().build().features.empty());
  EXPECT_TRUE(Mapper().build().grid.cells.empty());
}

TEST(Mapper, BoundsHoldWhatAllKeyFramesSaw) {
  const Mapper mapper = mapper_of(room_scans());
  ASSERT_TRUE(mapper.bounds().has_value());
  EXPECT_NEAR(mapper.bounds()->min.x(), 0.0, 0.05);
  EXPECT_NEAR(mapper.bounds()->min.y(), 0.0, 0.05);
  EXPECT_NEAR(mapper.bounds()->max.x(), 10.0, 0.05);
  EXPECT_NEAR(mapper.bounds()->max.y(), 10.0, 0.05);
}

TEST(Mapper, RefusesAScanThatWouldMakeTheGridTooLarge) {
  Mapper mapper;
  mapper.add(scan_at({6, 5, 0}));
  PosedScan far = scan_at({6, 5, 0});
  far.T_map_base_link = {5000.0, 5000.0, 0.0};
  const auto error = mapper.reject(far);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->field, "pose");
  EXPECT_EQ(mapper.key_frames().size(), 1U);
  far.T_map_base_link = {300.0, 300.0, 0.0};
  EXPECT_FALSE(mapper.reject(far).has_value());
}

TEST(Mapper, TakesAFarScanAsItsFirst) {
  PosedScan far = scan_at({6, 5, 0});
  far.T_map_base_link = {5e6, -3e6, 1.0};
  EXPECT_FALSE(Mapper().reject(far).has_value());
}

TEST(Mapper, RefusesAPoseThatIsNoNumber) {
  PosedScan nowhere = scan_at({6, 5, 0});
  nowhere.T_map_base_link.x = std::nan("");
  EXPECT_TRUE(Mapper().reject(nowhere).has_value());
}

TEST(Mapper, RefusesAScanWhoseNumbersAreNotFinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<PosedScan> scans(5, scan_at({6, 5, 0}));
  EXPECT_FALSE(Mapper().reject(scans[0]).has_value());
  scans[0].scan.angle_min = kNan;
  scans[1].scan.angle_increment = kNan;
  scans[2].scan.range_min = kNan;
  scans[3].T_base_link_laser.yaw = kNan;
  scans[4].T_map_base_link.x = kNan;
  for (const PosedScan& scan : scans) EXPECT_EQ(Mapper().reject(scan).value().field, "scan");
}

TEST(Mapper, RefusesParamsOutsideTheirLimits) {
  const auto field_of = [](const MapperParams& params) {
    const auto error = validate(params);
    return error ? error->field : "";
  };
  EXPECT_EQ(field_of({}), "");
  EXPECT_EQ(field_of({.key_frame_distance_m = -1.0}), "key_frame_distance_m");
  EXPECT_EQ(field_of({.key_frame_angle_rad = 4.0}), "key_frame_angle_rad");
  EXPECT_EQ(field_of({.min_feature_count = 0}), "min_feature_count");
  EXPECT_EQ(field_of({.grid = {.resolution_m = 0.0}}), "grid.resolution_m");
  EXPECT_EQ(field_of({.features = {.suppression_radius_m = 0.0}}), "features.suppression_radius_m");
  EXPECT_EQ(field_of({.descriptors = {.distance_resolution_m = 0.0}}),
            "descriptors.distance_resolution_m");
}

}  // namespace
}  // namespace cornerfix
