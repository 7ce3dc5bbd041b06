/// \file  A simulated robot of ROS 2 in the room of room_drive.hpp.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "integration/ros2/fast_dds_node.hpp"

namespace cornerfix::testing {

/// Publishes with the QoS of a common driver, and keeps what it receives.
class Ros2Robot {
 public:
  struct Options {
    std::string ns;          ///< Of its topics: "" or "/robot1".
    std::string prefix;      ///< Of its frames: "" or "robot1/".
    double begin_rad = 2.0;  ///< Where on the circle it starts.
    FastQos scan_qos = kSensorQos;
    FastQos odom_qos = kReliableQos;
    bool has_odometry_in_tf = false;  ///< On /tf and not on odom.
    bool is_upside_down = false;      ///< The laser.
    bool has_rear_lidar = false;      ///< On rear/scan; then both see half a turn.
    bool has_two_lidars = false;      ///< On front/scan and rear/scan, each of half a turn.
  };

  /// Publishes where the laser is, once, also for those that come later.
  Ros2Robot(std::uint32_t domain, Options options);

  /// Drives on by `count` scans. The client has reported its answer to each before the next one.
  void drive(std::size_t count);
  /// A covered lidar has no returns: its ranges are infinite.
  void cover_lidar(bool is_covered) { is_covered_ = is_covered; }
  /// As if its computer was started again: stamps begin anew.
  void restart_clock() { stamp_ -= 400.0; }

  /// Until `is_true`, at most `timeout`.
  template <typename Predicate>
  bool wait_until(Predicate is_true, std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
    std::unique_lock lock(mutex_);
    return event_.wait_for(lock, timeout, is_true);
  }
  /// Until the client receives its messages, and it those of the client.
  bool wait_for_client();

  struct TruePose {
    double stamp;
    Pose2 T_map_base_link;
    Pose2 T_odom_base_link;
  };
  /// At the stamp of a message.
  [[nodiscard]] TruePose truth(const ros::Header& header) const;

  // What was received; to be read when nothing is sent, or within wait_until().
  std::vector<ros::PoseWithCovarianceStamped> poses;
  std::vector<ros::TransformStamped> transforms;  ///< From map to odom.
  std::vector<ros::DiagnosticStatus> diagnoses;

  /// The status of the last answer; "" before.
  [[nodiscard]] std::string status() const {
    return diagnoses.empty() ? "" : diagnoses.back().value("status");
  }

 private:
  void publish_mount();
  void subscribe_transforms();
  void publish_odometry(const TruePose& pose);
  void publish_scans(const TruePose& pose);
  void publish_scan(FastDdsNode::Writer& writer, const Pose2& mount, const std::string& frame,
                    const TruePose& pose);
  /// What is sent by best effort is lost as long as the client has not discovered its publisher.
  /// Sent again with the same stamp, it changes nothing.
  void publish_until_answered(const TruePose& pose);
  [[nodiscard]] bool is_answered(double stamp) const;

  Options options_;
  std::mutex mutex_;
  std::condition_variable event_;
  std::vector<TruePose> driven_;
  double stamp_ = 500.0;
  bool is_covered_ = false;

  FastDdsNode node_;
  std::unique_ptr<FastDdsNode::Writer> tf_static_;
  std::unique_ptr<FastDdsNode::Writer> tf_;
  std::unique_ptr<FastDdsNode::Writer> odom_;
  std::unique_ptr<FastDdsNode::Writer> scan_;
  std::unique_ptr<FastDdsNode::Writer> rear_scan_;
};

/// Of a pose in the plane.
[[nodiscard]] Pose2 planar(const ros::Pose& pose);

}  // namespace cornerfix::testing
