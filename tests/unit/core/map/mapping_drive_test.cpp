#include "core/src/map/mapping_drive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace cornerfix {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::size_t> drive_lengths(const std::vector<double>& stamps) {
  std::vector<PosedScan> key_frames;
  for (const double stamp : stamps) key_frames.push_back({{.stamp = stamp, .ranges = {}}, {}, {}});
  std::vector<std::size_t> lengths;
  for (const auto& drive : drives_of(key_frames)) lengths.push_back(drive.size());
  return lengths;
}

TEST(MappingDrive, ScansThatFollowEachOtherAreOneDrive) {
  EXPECT_THAT(drive_lengths({1e9, 1e9 + 0.2, 1e9 + 200.0, 1e9 + 500.0}), ElementsAre(4));
}

TEST(MappingDrive, AnotherOneBeginsAfterMoreThanFiveMinutes) {
  EXPECT_THAT(drive_lengths({0.0, 1.0, 301.5, 302.0, 86400.0}), ElementsAre(2, 2, 1));
}

TEST(MappingDrive, AnotherOneBeginsWhereStampsGoFarBack) {
  EXPECT_THAT(drive_lengths({5000.0, 5001.0, 0.0, 1.0}), ElementsAre(2, 2));
}

TEST(MappingDrive, AFewScansOutOfOrderAreStillThatDrive) {
  EXPECT_THAT(drive_lengths({10.0, 12.0, 11.0, 13.0}), ElementsAre(4));
}

TEST(MappingDrive, NoKeyFramesAreNoDrive) { EXPECT_THAT(drive_lengths({}), IsEmpty()); }

}  // namespace
}  // namespace cornerfix
