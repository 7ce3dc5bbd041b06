#include "core/src/slam/drive_submap.hpp"

#include <gtest/gtest.h>

#include "support/matchers.hpp"
#include "support/posed_drive.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;

TEST(DriveSubmap, PiecesCoverTheDriveAndOverlapByHalf) {
  const std::vector<PosedScan>& drive = testing::office_drive();
  const std::vector<DrivePiece> pieces = cut_drive(drive);
  ASSERT_GE(pieces.size(), 3U);
  EXPECT_EQ(pieces.front().first, 0U);
  EXPECT_EQ(pieces.back().end, drive.size());
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    EXPECT_GT(pieces[i].first, pieces[i - 1].first);
    EXPECT_LT(pieces[i].first, pieces[i - 1].end);
  }
  for (std::size_t scan = 0; scan < drive.size(); ++scan) {
    const auto holding = std::ranges::count_if(
        pieces, [&](DrivePiece p) { return p.first <= scan && scan < p.end; });
    EXPECT_GE(holding, 1);
    EXPECT_LE(holding, 2);
  }
}

TEST(DriveSubmap, NoScansGiveNoPieces) { EXPECT_TRUE(cut_drive({}).empty()); }

TEST(DriveSubmap, IsFramedAtItsMiddleKeyFrame) {
  const std::vector<PosedScan>& drive = testing::office_drive();
  const DriveSubmap submap = make_drive_submap(drive, {2, 12});
  EXPECT_THAT(submap.T_drive_submap, IsPoseNear(drive[7].T_map_base_link, 1e-9, 1e-9));
  ASSERT_EQ(submap.way.size(), 10U);
  EXPECT_LT(submap.way[5].norm(), 1e-9);
  for (const Point2& position : submap.way) EXPECT_LE(position.norm(), submap.reach_m);
}

TEST(DriveSubmap, HasTheWallsThatItsScansSaw) {
  const std::vector<PosedScan>& drive = testing::office_drive();
  const DriveSubmap submap = make_drive_submap(drive, {0, 12});
  ASSERT_GT(submap.walls.size(), 100U);
  ASSERT_GT(submap.floor.size(), 100U);
  ASSERT_FALSE(submap.evidence.ends.empty());
  const testing::SceneBuilder scene = testing::offices();
  for (const Point2& wall : submap.walls)
    EXPECT_LT(scene.distance_to_walls(submap.T_drive_submap * wall), 0.1);
  const Pose2 T_grid_submap = submap.field.T_grid_frame();
  for (const Point2& end : submap.evidence.ends)
    EXPECT_LT(submap.field.nearest(T_grid_submap * end), 0.25);
}

}  // namespace
}  // namespace cornerfix
