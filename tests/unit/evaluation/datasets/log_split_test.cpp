#include "evaluation/datasets/log_split.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cornerfix::evaluation {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A scan a metre, every third without a pose.
RecordedLog walk(std::size_t scans) {
  RecordedLog log;
  for (std::size_t i = 0; i < scans; ++i) {
    LogScan scan;
    if (i % 3 != 2) scan.T_map_laser = Pose2{static_cast<double>(i), 0.0, 0.0};
    log.scans.push_back(scan);
  }
  return log;
}

TEST(LogSplit, TakesTheFirstShareOfThePosedScansForTheMap) {
  const DividedLog divided = divide(walk(9), ShareSplit{0.5});
  EXPECT_THAT(divided.mapping, ElementsAre(0, 1, 3));
  EXPECT_THAT(divided.asking, ElementsAre(4, 6, 7));
}

TEST(LogSplit, MayLeaveOnePartEmpty) {
  EXPECT_THAT(divide(walk(9), ShareSplit{0.0}).mapping, IsEmpty());
  EXPECT_THAT(divide(walk(9), ShareSplit{1.0}).asking, IsEmpty());
}

TEST(LogSplit, LetsBlocksOfWayTakeTurns) {
  const DividedLog divided = divide(walk(12), BlockSplit{4.0});
  EXPECT_THAT(divided.mapping, ElementsAre(0, 1, 3, 9, 10));
  EXPECT_THAT(divided.asking, ElementsAre(4, 6, 7));
}

TEST(LogSplit, ParsesSharesAndBlocks) {
  const auto share = parse_log_split("0.25");
  ASSERT_TRUE(share);
  EXPECT_EQ(std::get<ShareSplit>(*share).share, 0.25);
  const auto blocks = parse_log_split("blocks:30");
  ASSERT_TRUE(blocks);
  EXPECT_EQ(std::get<BlockSplit>(*blocks).block_m, 30.0);
  for (const char* wrong : {"", "1.5", "-0.1", "nan", "0.5x", "blocks:", "blocks:0", "blocks:-3",
                            "blocks:inf", "block:3"}) {
    EXPECT_FALSE(parse_log_split(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace cornerfix::evaluation
