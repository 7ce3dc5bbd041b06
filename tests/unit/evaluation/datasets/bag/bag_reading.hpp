/// \file  A recorded run in bags of all kinds, and how tests read them.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "evaluation/datasets/log_reader.hpp"
#include "support/temporary_directory.hpp"
#include "unit/evaluation/datasets/bag/bag_writers.hpp"

namespace cornerfix::evaluation {

inline constexpr double kPi = std::numbers::pi;
inline constexpr WireFormat kRos1 = WireFormat::kRos1;
inline constexpr WireFormat kCdr = WireFormat::kCdr;

inline WrittenMessage scan_message(WireFormat format, double stamp,
                                   const std::string& topic = "/scan") {
  const char* type = format == kRos1 ? "sensor_msgs/LaserScan" : "sensor_msgs/msg/LaserScan";
  return {stamp + 0.01, topic, type, laser_scan(format, stamp, {1.5F, 2.5F, 30.0F})};
}

inline WrittenMessage odometry_message(WireFormat format, double stamp, double x, double y,
                                       double yaw, const std::string& topic = "/odom") {
  const char* type = format == kRos1 ? "nav_msgs/Odometry" : "nav_msgs/msg/Odometry";
  return {stamp + 0.01, topic, type, odometry(format, stamp, x, y, yaw)};
}

inline WrittenMessage tf_message(WireFormat format, double stamp,
                                 const std::vector<WrittenTransform>& list,
                                 const std::string& topic = "/tf") {
  return {stamp + 0.01, topic, format == kRos1 ? "tf2_msgs/TFMessage" : "tf2_msgs/msg/TFMessage",
          transforms(format, stamp, list)};
}

/// A robot that drives along y = 1 at 1 m/s, its laser 0.5 m ahead; the map lies a quarter turn off
/// the odometry. Scans half-way between the transforms.
inline std::vector<std::vector<WrittenMessage>> drive(WireFormat format, std::size_t scans) {
  std::vector<std::vector<WrittenMessage>> chunks;
  chunks.push_back(
      {tf_message(format, 99.0, {{"base_link", "laser", 0.5, 0.0, 0.0}}, "/tf_static")});
  for (std::size_t i = 0; i <= scans; ++i) {
    const double x = 0.1 * static_cast<double>(i);
    const double stamp = 100.0 + x;
    chunks.push_back(
        {tf_message(format, stamp,
                    {{"odom", "base_link", x, 1.0, 0.0}, {"map", "odom", 10.0, 0.0, kPi / 2.0}}),
         {stamp, "/camera", "sensor_msgs/Image", "pixels"}});
    if (i < scans) chunks.back().push_back(scan_message(format, stamp + 0.05));
  }
  return chunks;
}

inline void expect_drive(const RecordedLog& log, std::size_t scans) {
  ASSERT_EQ(log.scans.size(), scans);
  EXPECT_EQ(log.header.beams, 3U);
  EXPECT_DOUBLE_EQ(log.header.lidar.angle_min, -1.0);
  EXPECT_DOUBLE_EQ(log.header.lidar.range_max, 20.0);
  for (std::size_t i = 0; i < scans; ++i) {
    const LogScan& scan = log.scans[i];
    const double x = 0.1 * static_cast<double>(i) + 0.05;
    EXPECT_NEAR(scan.scan.stamp, 100.0 + x, 1e-6);
    EXPECT_EQ(scan.scan.ranges, (std::vector<float>{1.5F, 2.5F, 30.0F}));
    ASSERT_TRUE(scan.T_odom_laser);
    EXPECT_NEAR(scan.T_odom_laser->x, x + 0.5, 1e-5);
    EXPECT_NEAR(scan.T_odom_laser->y, 1.0, 1e-9);
    ASSERT_TRUE(scan.T_map_laser);
    EXPECT_NEAR(scan.T_map_laser->x, 9.0, 1e-9);
    EXPECT_NEAR(scan.T_map_laser->y, x + 0.5, 1e-5);
    EXPECT_NEAR(scan.T_map_laser->yaw, kPi / 2.0, 1e-9);
  }
}

/// The same in one list.
inline std::vector<WrittenMessage> messages_of(
    const std::vector<std::vector<WrittenMessage>>& chunks) {
  std::vector<WrittenMessage> messages;
  for (const auto& chunk : chunks) messages.insert(messages.end(), chunk.begin(), chunk.end());
  return messages;
}

class BagReading : public ::testing::Test {
 protected:
  /// All scans, and what was left out on the way.
  RecordedLog read(const std::filesystem::path& path, const LogSelection& selection = {}) {
    Result<LogReader> reader = LogReader::open(path, selection);
    if (!reader) {
      ADD_FAILURE() << reader.error().message;
      return {};
    }
    RecordedLog log = read_all(*reader);
    faults_ = reader->faults();
    remarks_ = remarks(*reader);
    return log;
  }

  testing::TemporaryDirectory directory_;
  LogFaults faults_;
  std::string remarks_;
};

}  // namespace cornerfix::evaluation
