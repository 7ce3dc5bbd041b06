#include "evaluation/simulation/odometry_fault.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "evaluation/simulation/seeded_random.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kHangPeriod = 20.0;   // [s]
constexpr double kHangLength = 10.0;   // [s]
constexpr double kLeastJump = 5.0;     // [m]
constexpr double kLargestJump = 50.0;  // [m]
constexpr double kJumpBefore = 8.0;    // [m] driven, at the latest
constexpr double kLeastHeadingError = std::numbers::pi / 6.0;
constexpr double kLargestHeadingError = 2.0 * std::numbers::pi / 3.0;

constexpr std::array<std::pair<OdometryFaultKind, std::string_view>, 5> kNames{
    {{OdometryFaultKind::kZero, "zero"},
     {OdometryFaultKind::kHang, "hang"},
     {OdometryFaultKind::kTwoPublishers, "two_publishers"},
     {OdometryFaultKind::kWrongHeading, "wrong_heading"},
     {OdometryFaultKind::kJump, "jump"}}};

}  // namespace

std::optional<OdometryFaultKind> odometry_fault_from_string(std::string_view name) {
  const auto found =
      std::ranges::find(kNames, name, [](const auto& entry) { return entry.second; });
  if (found == kNames.end()) return std::nullopt;
  return found->first;
}

std::string_view to_string(OdometryFaultKind kind) {
  return std::ranges::find(kNames, kind, [](const auto& entry) { return entry.first; })->second;
}

const std::vector<OdometryFaultKind>& all_odometry_faults() {
  static const std::vector<OdometryFaultKind> kinds = [] {
    std::vector<OdometryFaultKind> all;
    all.reserve(kNames.size());
    for (const auto& [kind, name] : kNames) all.push_back(kind);
    return all;
  }();
  return kinds;
}

std::vector<std::string> odometry_fault_names() {
  std::vector<std::string> names;
  names.reserve(kNames.size());
  for (const auto& [kind, name] : kNames) names.emplace_back(name);
  return names;
}

OdometryFault::OdometryFault(OdometryFaultKind kind, std::uint64_t seed) : kind_(kind) {
  SeededRandom random(seed);
  hang_phase_s_ = random.uniform(0.0, kHangPeriod - kHangLength);
  heading_error_ =
      random.uniform(kLeastHeadingError, kLargestHeadingError) * (random.chance(0.5) ? -1.0 : 1.0);
  jump_after_m_ = random.uniform(0.0, kJumpBefore);
  const double size_m = random.uniform(kLeastJump, kLargestJump);
  const double direction = random.uniform(-std::numbers::pi, std::numbers::pi);
  T_other_odom_ = {size_m * std::cos(direction), size_m * std::sin(direction),
                   random.uniform(-std::numbers::pi, std::numbers::pi)};
}

Pose2 OdometryFault::corrupt(double stamp, const Pose2& T_odom_base_link) {
  if (!first_stamp_) first_stamp_ = stamp;
  if (last_) driven_m_ += distance(*last_, T_odom_base_link);
  last_ = T_odom_base_link;
  is_odd_scan_ = !is_odd_scan_;
  switch (kind_) {
    case OdometryFaultKind::kZero:
      return {};
    case OdometryFaultKind::kHang:
      return hung(stamp - *first_stamp_, T_odom_base_link);
    case OdometryFaultKind::kTwoPublishers:
      return is_odd_scan_ ? T_odom_base_link : T_other_odom_ * T_odom_base_link;
    case OdometryFaultKind::kWrongHeading:
      return {T_odom_base_link.x, T_odom_base_link.y,
              wrap_angle(T_odom_base_link.yaw + heading_error_)};
    case OdometryFaultKind::kJump:
      break;
  }
  return jumped(T_odom_base_link);
}

Pose2 OdometryFault::hung(double elapsed_s, const Pose2& T_odom_base_link) {
  const double in_period_s = std::fmod(elapsed_s + hang_phase_s_, kHangPeriod);
  if (in_period_s < kHangPeriod - kHangLength) {
    held_.reset();
    return T_odom_base_link;
  }
  if (!held_) held_ = T_odom_base_link;
  return *held_;
}

Pose2 OdometryFault::jumped(const Pose2& T_odom_base_link) {
  if (driven_m_ < jump_after_m_) return T_odom_base_link;
  if (!T_after_before_) {
    const Pose2 landed{T_odom_base_link.x + T_other_odom_.x, T_odom_base_link.y + T_other_odom_.y,
                       T_other_odom_.yaw};
    T_after_before_ = landed * inverse(T_odom_base_link);
  }
  return *T_after_before_ * T_odom_base_link;
}

}  // namespace cornerfix::evaluation
