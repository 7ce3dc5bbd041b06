/// \file  Joins scans, transforms and odometry, which come as separate messages, to what the HTTP
/// API takes.
#pragma once

#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "frames/floor_pose.hpp"
#include "frames/frame_tree.hpp"
#include "frames/robot_odometry.hpp"

namespace cornerfix::ros2 {

/// sensor_msgs/LaserScan.
struct ReceivedScan {
  std::string frame;
  LaserScan scan;
  double time_increment = 0.0;  ///< From beam to beam [s].
};

/// A scan that can be posted.
struct AssembledScan {
  LaserScan scan;
  double time_increment = 0.0;
  Pose2 T_base_link_laser;
  std::optional<Pose2> T_odom_base_link;  ///< At the stamp.
  bool begins_run = false;                ///< The clock was set back before it.
};

/// Not synchronised.
class ScanAssembler {
 public:
  using Clock = std::chrono::steady_clock;

  struct Options {
    std::string base_frame = "base_link";  ///< "robot1/base_link" is called so, too.
    double max_rate_hz = 10.0;             ///< More scans per second of stamps are left out.
  };

  explicit ScanAssembler(Options options) : options_(std::move(options)) {}

  void add_scan(ReceivedScan scan, Clock::time_point now);
  void add_odometry(const StampedTransform& T_odom_child) { odometry_.add(T_odom_child); }
  void add_transform(const StampedTransform& transform, FrameTree::Origin origin) {
    frames_.add(transform, origin);
  }

  /// The scans that go into one request: of one lidar and one run, in order of their stamps. A scan
  /// waits for odometry after its stamp, but no longer than a quarter of a second. Empty when none
  /// is ready.
  [[nodiscard]] std::vector<AssembledScan> take_batch(Clock::time_point now);

  /// When a waiting scan is ready even if nothing more arrives.
  [[nodiscard]] std::optional<Clock::time_point> next_deadline() const;

  /// The frame above the base in which the odometry is; empty when there is none.
  [[nodiscard]] std::string odom_frame() const;

  /// Why the last scan could not be used; empty when it could.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  struct Waiting {
    ReceivedScan message;
    Clock::time_point received;
    bool begins_run = false;
  };
  struct Ready {
    AssembledScan scan;
    Clock::time_point received;
  };

  /// False for a scan to be left out.
  bool accept_stamp(double stamp, bool& begins_run);
  void move_ready(Clock::time_point now);
  /// The base of the robot with the transform from the laser.
  [[nodiscard]] std::optional<FrameTree::Ancestor> find_base(const ReceivedScan& scan) const;
  void finish(const Waiting& waiting, const Eigen::Isometry3d& T_base_laser,
              const std::optional<RobotOdometry::Found>& odometry);

  Options options_;
  FrameTree frames_;
  RobotOdometry odometry_{/*is_chosen=*/false};
  std::deque<Waiting> waiting_;
  std::deque<Ready> ready_;
  std::optional<double> last_stamp_;
  std::string base_;  ///< Full name; empty until a transform from the laser is known.
  std::string problem_;
};

}  // namespace cornerfix::ros2
