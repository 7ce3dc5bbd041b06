#include "core/src/slam/submap_mosaic.hpp"

#include <gtest/gtest.h>

#include "support/posed_drive.hpp"

namespace cornerfix {
namespace {

struct OfficeSubmaps {
  std::vector<DriveSubmap> submaps;
  std::vector<Pose2> poses;
};

OfficeSubmaps office_submaps() {
  OfficeSubmaps all;
  for (const DrivePiece piece : cut_drive(testing::office_drive())) {
    all.submaps.push_back(make_drive_submap(testing::office_drive(), piece));
    all.poses.push_back(all.submaps.back().T_drive_submap);
  }
  return all;
}

std::uint8_t pass_class_at(const SubmapMosaic& mosaic, const Point2& point_map) {
  const Point2 cell = mosaic.classes().T_grid_map() * point_map / mosaic.classes().resolution();
  return static_cast<std::uint8_t>(mosaic.classes().pass_class(
      static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))));
}

TEST(SubmapMosaic, ShowsWallsAndFreeSpaceWhereTheyAre) {
  const OfficeSubmaps all = office_submaps();
  const SubmapMosaic mosaic(all.submaps, all.poses);
  const Pose2 T_grid_map = mosaic.field().T_grid_frame();
  EXPECT_LT(mosaic.field().nearest(T_grid_map * Point2(5.0, 5.0)), 0.1) << "a wall of a room";
  EXPECT_GT(mosaic.field().nearest(T_grid_map * Point2(2.0, 4.5)), 0.8) << "the middle of a room";
  EXPECT_EQ(pass_class_at(mosaic, {2.0, 4.5}), static_cast<std::uint8_t>(PassClass::kFree));
  EXPECT_EQ(pass_class_at(mosaic, {14.0, 5.0}), static_cast<std::uint8_t>(PassClass::kUnknown))
      << "a room that the robot did not visit";
}

TEST(SubmapMosaic, MovesWithItsSubmaps) {
  OfficeSubmaps all = office_submaps();
  const double area_m2 = SubmapMosaic(all.submaps, all.poses).free_area_m2();
  EXPECT_GT(area_m2, 40.0);
  const Pose2 T{100.0, -50.0, 1.0};
  for (Pose2& pose : all.poses) pose = T * pose;
  const SubmapMosaic moved(all.submaps, all.poses);
  EXPECT_NEAR(moved.free_area_m2(), area_m2, 0.05 * area_m2);
  EXPECT_EQ(pass_class_at(moved, T * Point2(2.0, 4.5)),
            static_cast<std::uint8_t>(PassClass::kFree));
}

}  // namespace
}  // namespace cornerfix
