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
  std::string lidar;  ///< Its name; empty for the only one.
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
    double max_rate_hz = 10.0;  ///< More scans of a lidar per second of stamps are left out.
    std::vector<std::string> lidars = {""};  ///< Names, of several; else one that is empty.
  };

  explicit ScanAssembler(Options options);

  /// \param lidar  Index in the options.
  void add_scan(ReceivedScan scan, Clock::time_point now, std::size_t lidar = 0);
  /// Nothing stands for a message without a pose.
  void add_odometry(const std::optional<StampedTransform>& T_odom_child);
  void add_transform(const StampedTransform& transform, FrameTree::Origin origin) {
    frames_.add(transform, origin);
  }

  /// The scans that go into one request: of one run, in order of their stamps. A scan waits for
  /// odometry after its stamp, and for scans of the other lidars up to its stamp, but no longer
  /// than a quarter of a second. Empty when none is ready.
  [[nodiscard]] std::vector<AssembledScan> take_batch(Clock::time_point now);

  /// When a waiting scan is ready even if nothing more arrives; after `now`.
  [[nodiscard]] std::optional<Clock::time_point> next_deadline(Clock::time_point now) const;

  /// The frame above the base in which the odometry is; empty when there is none.
  [[nodiscard]] std::string odom_frame() const;

  /// Why the last scan of a lidar or the last odometry could not be used, or which lidar is silent
  /// while others are not; empty when all are well.
  [[nodiscard]] std::string problem() const;

 private:
  struct Waiting {
    ReceivedScan message;
    Clock::time_point received;
  };
  struct Ready {
    AssembledScan scan;
    Clock::time_point received;
  };
  struct Lidar {
    std::string name;
    std::deque<Waiting> waiting;  ///< For transforms and odometry.
    std::optional<double> last_stamp;
    std::optional<double> last_ready;  ///< Stamp.
    std::string problem;
  };

  /// False for a scan to be left out.
  bool accept_stamp(Lidar& lidar, double stamp);
  /// The clock was set back to `stamp`.
  void begin_run(double stamp);
  void move_ready(Lidar& lidar, Clock::time_point now);
  /// The base of the robot with the transform from the laser.
  [[nodiscard]] std::optional<FrameTree::Ancestor> find_base(const ReceivedScan& scan) const;
  void finish(Lidar& lidar, const Waiting& waiting, const Eigen::Isometry3d& T_base_laser,
              const std::optional<RobotOdometry::Found>& odometry);
  void insert(Ready ready);
  /// How many of the first ready scans no other lidar can come before.
  [[nodiscard]] std::size_t count_complete(Clock::time_point now) const;
  [[nodiscard]] bool is_complete(const Ready& ready, Clock::time_point now) const;
  /// Whether one of the first `count` ready scans was taken beam by beam and is the only one of its
  /// lidar. A second one in the same request gives the motion.
  [[nodiscard]] bool lacks_motion(std::size_t count) const;
  /// Far behind the others, or not heard yet.
  [[nodiscard]] bool is_silent(const Lidar& lidar) const;
  /// Of all lidars; 0 before the first scan.
  [[nodiscard]] double newest_stamp() const;

  Options options_;
  FrameTree frames_;
  RobotOdometry odometry_{/*is_chosen=*/false};
  bool is_odometry_broken_ = false;  ///< The last message of it.
  std::vector<Lidar> lidars_;
  std::deque<Ready> ready_;           ///< By stamp.
  std::optional<double> last_taken_;  ///< Stamp of the last scan of the last batch.
  bool begins_run_ = false;           ///< The next batch does.
  std::string base_;  ///< Full name; empty until a transform from the laser is known.
};

}  // namespace cornerfix::ros2
