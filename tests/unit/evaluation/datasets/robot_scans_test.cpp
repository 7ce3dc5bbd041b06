#include "evaluation/datasets/robot_scans.hpp"

#include <gtest/gtest.h>

#include <string>

#include "support/temporary_directory.hpp"

namespace cornerfix::evaluation {
namespace {

class RobotScansOfALog : public ::testing::Test {
 protected:
  /// Scans a second and a metre apart.
  [[nodiscard]] std::string log_of(int scans) const {
    std::string text = R"({"name": "walk", "beams": 2, "angle_min": 0, "angle_increment": 1, )"
                       R"("range_min": 0.1, "range_max": 9})"
                       "\n";
    for (int i = 0; i < scans; ++i) {
      const std::string number = std::to_string(i);
      text += R"({"t": )" + number + R"(, "ranges": [1, 2], "pose": [)" + number + ", 0, 0]}\n";
    }
    return directory_.write("walk.jsonl", text).string();
  }

  testing::TemporaryDirectory directory_;
};

TEST_F(RobotScansOfALog, ComeInBatchesWithARestAtTheEnd) {
  Result<RobotScans> scans = RobotScans::open(log_of(5), {});
  ASSERT_TRUE(scans.ok()) << scans.error().message;
  EXPECT_EQ(scans->next_batch(3).size(), 3U);
  EXPECT_EQ(scans->next_batch(3).size(), 2U);
  EXPECT_TRUE(scans->next_batch(3).empty());
}

TEST_F(RobotScansOfALog, BeginBehindTheShareThatMadeTheMap) {
  Result<RobotScans> scans =
      RobotScans::open(log_of(10), {.selection = {}, .from = LogTime{2.0}, .split = 0.5});
  ASSERT_TRUE(scans.ok()) << scans.error().message;
  EXPECT_EQ(scans->next_batch(1).front().scan.stamp, 7.0);
}

TEST_F(RobotScansOfALog, AreAnErrorBehindTheEnd) {
  EXPECT_FALSE(RobotScans::open(log_of(3), {.selection = {}, .from = std::size_t{3}}).ok());
}

TEST(DistanceTraveled, SumsReferencePosesOrElseOdometryAndSkipsPauses) {
  LogScan at_origin;
  at_origin.T_map_laser = Pose2{};
  at_origin.T_odom_laser = Pose2{};
  LogScan ahead;
  ahead.T_map_laser = Pose2{3.0, 4.0, 0.0};
  ahead.T_odom_laser = Pose2{9.0, 0.0, 0.0};
  LogScan without_reference;
  without_reference.T_odom_laser = Pose2{10.0, 0.0, 0.0};
  LogScan later_run = at_origin;
  later_run.begins_run = true;
  DistanceTraveled distance;
  for (const LogScan& scan : {at_origin, ahead, without_reference, later_run}) distance.add(scan);
  EXPECT_DOUBLE_EQ(distance.m(), 6.0);
}

TEST(LogClock, CountsNoPauseBetweenRuns) {
  const auto scan_at = [](double stamp, bool begins_run) {
    LogScan scan;
    scan.scan.stamp = stamp;
    scan.begins_run = begins_run;
    return scan;
  };
  LogClock clock;
  clock.add(std::vector{scan_at(100.0, false), scan_at(101.0, false)});
  clock.add(std::vector{scan_at(102.0, false)});
  clock.add(std::vector{scan_at(900.0, true), scan_at(900.5, false)});
  EXPECT_DOUBLE_EQ(clock.seconds(), 2.5);
}

}  // namespace
}  // namespace cornerfix::evaluation
