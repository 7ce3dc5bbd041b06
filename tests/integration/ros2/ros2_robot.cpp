#include "integration/ros2/ros2_robot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "support/room_drive.hpp"

namespace cornerfix::testing {

namespace {

constexpr double kStepRad = 0.1;
const Pose2 kMount{0.2, -0.1, 0.3};  ///< Of the laser in base_link.
const Pose2 kRearMount{-0.2, 0.1, 0.3 + std::numbers::pi};
const Pose2 kStartInOdom{3.0, -2.0, 1.0};  ///< Odometry begins anywhere.
constexpr double kFirstStamp = 500.0;

ros::Header header(double stamp, const std::string& frame) {
  const double whole = std::floor(stamp);
  return {static_cast<std::int32_t>(whole),
          static_cast<std::uint32_t>(std::lround((stamp - whole) * 1e9)), frame};
}

double stamp_of(const ros::Header& header) { return header.sec + 1e-9 * header.nanosec; }

ros::Pose spatial(const Pose2& pose) {
  return {{pose.x, pose.y, 0.0}, {0.0, 0.0, std::sin(pose.yaw / 2.0), std::cos(pose.yaw / 2.0)}};
}

/// What a lidar of half a turn sees.
LaserScan front_half(LaserScan scan) {
  const std::size_t quarter = scan.ranges.size() / 4;
  scan.angle_min = scan.bearing(quarter);
  scan.ranges = {scan.ranges.begin() + static_cast<std::ptrdiff_t>(quarter),
                 scan.ranges.end() - static_cast<std::ptrdiff_t>(quarter)};
  return scan;
}

}  // namespace

Pose2 planar(const ros::Pose& pose) {
  return {pose.position[0], pose.position[1],
          2.0 * std::atan2(pose.orientation[2], pose.orientation[3])};
}

Ros2Robot::Ros2Robot(std::uint32_t domain, Options options)
    : options_(std::move(options)), node_(domain) {
  node_.on_event([this] {
    { const std::lock_guard lock(mutex_); }  // What was changed before is seen by who waits.
    event_.notify_all();
  });
  const std::string topic = "rt" + options_.ns;
  tf_static_ = node_.advertise<ros::TfMessage>("rt/tf_static", kTfStaticQos);
  publish_mount();
  odom_ = options_.has_odometry_in_tf
              ? nullptr
              : node_.advertise<ros::Odometry>(topic + "/odom", options_.odom_qos);
  scan_ = node_.advertise<ros::LaserScan>(topic + "/scan", options_.scan_qos);
  if (options_.has_rear_lidar)
    rear_scan_ = node_.advertise<ros::LaserScan>(topic + "/rear/scan", options_.scan_qos);
  node_.subscribe<ros::PoseWithCovarianceStamped>(
      topic + "/initialpose", kReliableQos, [this](const ros::PoseWithCovarianceStamped& pose) {
        const std::lock_guard lock(mutex_);
        poses.push_back(pose);
      });
  if (options_.has_odometry_in_tf) {
    tf_ = node_.advertise<ros::TfMessage>("rt/tf", kTfQos);
  } else {
    subscribe_transforms();
  }
  node_.subscribe<ros::DiagnosticArray>(
      "rt/diagnostics", kReliableQos, [this](const ros::DiagnosticArray& array) {
        const std::lock_guard lock(mutex_);
        for (const ros::DiagnosticStatus& status : array.status) {
          if (options_.ns.empty() || "/" + status.hardware_id == options_.ns) {
            diagnoses.push_back(status);
          }
        }
      });
}

void Ros2Robot::subscribe_transforms() {
  node_.subscribe<ros::TfMessage>("rt/tf", kTfQos, [this](const ros::TfMessage& message) {
    const std::lock_guard lock(mutex_);
    for (const ros::TransformStamped& transform : message.transforms) {
      if (transform.child_frame_id == options_.prefix + "odom") transforms.push_back(transform);
    }
  });
}

bool Ros2Robot::wait_for_client() {
  return wait_until([this] {
    return !diagnoses.empty() && scan_->matched() > 0 &&
           (!rear_scan_ || rear_scan_->matched() > 0) &&
           (options_.has_odometry_in_tf ? tf_ : odom_)->matched() > 0;
  });
}

void Ros2Robot::publish_mount() {
  ros::Pose mount = spatial(kMount);
  if (options_.is_upside_down) {  // Turned by pi about its own x axis.
    const double half = kMount.yaw / 2.0;
    mount.orientation = {std::cos(half), std::sin(half), 0.0, 0.0};
  }
  ros::TfMessage message;
  message.transforms.push_back(
      {header(0.0, options_.prefix + "base_link"), options_.prefix + "laser", mount});
  message.transforms.push_back({header(0.0, options_.prefix + "base_link"),
                                options_.prefix + "rear_laser", spatial(kRearMount)});
  tf_static_->write(&message);
}

void Ros2Robot::publish_odometry(const TruePose& pose) {
  const ros::Pose in_odom = spatial(pose.T_odom_base_link);
  const std::string base = options_.prefix + "base_link";
  if (options_.has_odometry_in_tf) {
    ros::TfMessage message;
    message.transforms.push_back({header(pose.stamp, options_.prefix + "odom"), base, in_odom});
    return tf_->write(&message);
  }
  ros::Odometry odometry;
  odometry.header = header(pose.stamp, options_.prefix + "odom");
  odometry.child_frame_id = base;
  odometry.pose = in_odom;
  odom_->write(&odometry);
}

void Ros2Robot::publish_scans(const TruePose& pose) {
  publish_scan(*scan_, kMount, "laser", pose);
  if (rear_scan_) publish_scan(*rear_scan_, kRearMount, "rear_laser", pose);
}

void Ros2Robot::publish_scan(FastDdsNode::Writer& writer, const Pose2& mount,
                             const std::string& frame, const TruePose& pose) {
  LaserScan seen = scan_in_room(pose.T_map_base_link * mount, pose.stamp);
  if (options_.has_rear_lidar) seen = front_half(std::move(seen));
  if (options_.is_upside_down) {  // Its beam i looks where the one as far on the other side would.
    std::reverse(seen.ranges.begin(), seen.ranges.end());
    seen.angle_min = -seen.bearing(seen.ranges.size() - 1);
  }
  ros::LaserScan scan;
  scan.header = header(pose.stamp, options_.prefix + frame);
  scan.angle_min = static_cast<float>(seen.angle_min);
  scan.angle_max = static_cast<float>(seen.bearing(seen.ranges.size() - 1));
  scan.angle_increment = static_cast<float>(seen.angle_increment);
  scan.scan_time = static_cast<float>(kScanPeriodS);
  scan.range_min = static_cast<float>(seen.range_min);
  scan.range_max = static_cast<float>(seen.range_max);
  scan.ranges = seen.ranges;
  if (is_covered_) std::ranges::fill(scan.ranges, std::numeric_limits<float>::infinity());
  writer.write(&scan);
}

bool Ros2Robot::is_answered(double stamp) const {
  if (diagnoses.empty()) return false;
  const std::string last = diagnoses.back().value("stamp");
  return !last.empty() && std::abs(std::stod(last) - stamp) < 1e-3;
}

void Ros2Robot::drive(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = options_.begin_rad + static_cast<double>(driven_.size()) * kStepRad;
    const Pose2 pose = circle_in_room(1.6, angle, 0.0, 1).front();
    const Pose2 start = driven_.empty() ? pose : driven_.front().T_map_base_link;
    driven_.push_back({stamp_, pose, kStartInOdom * inverse(start) * pose});
    publish_until_answered(driven_.back());
    stamp_ += kScanPeriodS;
  }
}

void Ros2Robot::publish_until_answered(const TruePose& pose) {
  constexpr std::chrono::milliseconds kUntilRepeated{500};
  constexpr int kMostRepeats = 40;
  for (int repeat = 0; repeat < kMostRepeats; ++repeat) {
    publish_odometry(pose);
    publish_scans(pose);
    if (wait_until([&] { return is_answered(pose.stamp); }, kUntilRepeated)) return;
  }
}

Ros2Robot::TruePose Ros2Robot::truth(const ros::Header& header) const {
  const double stamp = stamp_of(header);
  const auto nearest = std::ranges::min_element(
      driven_, {}, [&](const TruePose& pose) { return std::abs(pose.stamp - stamp); });
  return *nearest;
}

}  // namespace cornerfix::testing
