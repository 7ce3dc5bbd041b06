/// \file  Odometry as faulty robots report it, made from the odometry of a good run.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix::evaluation {

/// Kinds that users report (slam_toolbox#438, rtabmap_ros#760, turtlebot4#131).
enum class OdometryFaultKind : std::uint8_t {
  kZero,           ///< The pose is always 0.
  kHang,           ///< Every 20 s the pose freezes for 10 s, then jumps to the true value.
  kTwoPublishers,  ///< Alternates between the true odometry and that of another odom frame.
  kWrongHeading,   ///< The heading is off by a constant angle: the robot seems to drive sideways.
  kJump,           ///< The pose jumps once, by 5 to 50 m, and is correct relative to that later.
};

/// zero, hang, two_publishers, wrong_heading or jump; nothing for any other name.
[[nodiscard]] std::optional<OdometryFaultKind> odometry_fault_from_string(std::string_view name);
[[nodiscard]] std::string_view to_string(OdometryFaultKind kind);
[[nodiscard]] const std::vector<OdometryFaultKind>& all_odometry_faults();
[[nodiscard]] std::vector<std::string> odometry_fault_names();

/// The odometry of one robot with one fault. Deterministic: the same kind, seed and poses give the
/// same poses. Sizes, times and angles are drawn from `seed`, so that robots differ.
class OdometryFault {
 public:
  OdometryFault(OdometryFaultKind kind, std::uint64_t seed);

  /// Takes the odometry of one scan after the other, with its stamp [s]; returns what the faulty
  /// robot reports. The frame is `odom`.
  [[nodiscard]] Pose2 corrupt(double stamp, const Pose2& T_odom_base_link);

 private:
  [[nodiscard]] Pose2 hung(double elapsed_s, const Pose2& T_odom_base_link);
  [[nodiscard]] Pose2 jumped(const Pose2& T_odom_base_link);

  OdometryFaultKind kind_;
  double hang_phase_s_ = 0.0;  ///< Into the period at the first scan.
  double heading_error_ = 0.0;
  double jump_after_m_ = 0.0;
  Pose2 T_other_odom_;  ///< The second publisher's frame, or how far the pose jumps.
  std::optional<double> first_stamp_;
  std::optional<Pose2> last_;            ///< True odometry at the last scan.
  std::optional<Pose2> held_;            ///< While it hangs.
  std::optional<Pose2> T_after_before_;  ///< Once it has jumped.
  double driven_m_ = 0.0;
  bool is_odd_scan_ = false;
};

}  // namespace cornerfix::evaluation
