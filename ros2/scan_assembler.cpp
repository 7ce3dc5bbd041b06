#include "ros2/scan_assembler.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cornerfix::ros2 {

namespace {

constexpr auto kMaxWait = std::chrono::milliseconds(250);
constexpr std::size_t kMaxKept = 50;   ///< While the server searches or cannot be reached.
constexpr std::size_t kMaxBatch = 20;  ///< Scans of a request.
constexpr double kSetBackSeconds = 2.0;
/// Of the period of the scans. A lidar's own jitter must not halve its rate.
constexpr double kPeriodTolerance = 0.1;

bool is_called(const std::string& frame, const std::string& name) {
  return frame == name || frame.ends_with("/" + name);
}

/// Seen from above: the beams of a lidar that hangs upside down turn clockwise.
LaserScan seen_from_above(LaserScan scan, double upright) {
  if (upright < 0.0) {
    scan.angle_min = -scan.angle_min;
    scan.angle_increment = -scan.angle_increment;
  }
  return scan;
}

bool have_one_lidar(const AssembledScan& a, const AssembledScan& b) {
  const LaserScan& p = a.scan;
  const LaserScan& q = b.scan;
  return p.angle_min == q.angle_min && p.angle_increment == q.angle_increment &&
         p.range_min == q.range_min && p.range_max == q.range_max &&
         a.time_increment == b.time_increment && a.T_base_link_laser == b.T_base_link_laser;
}

}  // namespace

void ScanAssembler::add_scan(ReceivedScan scan, Clock::time_point now) {
  if (const auto error = validate(scan.scan)) {
    problem_ = "a scan that no lidar makes: " + error->field + " " + error->message;
    return;
  }
  bool begins_run = false;
  if (!accept_stamp(scan.scan.stamp, begins_run)) return;
  waiting_.push_back({std::move(scan), now, begins_run});
  if (waiting_.size() > kMaxKept) {
    const bool lost_begin = waiting_.front().begins_run;
    waiting_.pop_front();
    waiting_.front().begins_run |= lost_begin;
  }
}

bool ScanAssembler::accept_stamp(double stamp, bool& begins_run) {
  if (last_stamp_) {
    begins_run = stamp < *last_stamp_ - kSetBackSeconds;
    const double least = (1.0 - kPeriodTolerance) / options_.max_rate_hz;
    if (!begins_run && stamp - *last_stamp_ < least) return false;
  }
  if (begins_run) {
    waiting_.clear();
    ready_.clear();
  }
  last_stamp_ = stamp;
  return true;
}

std::optional<FrameTree::Ancestor> ScanAssembler::find_base(const ReceivedScan& scan) const {
  for (FrameTree::Ancestor& above : frames_.ancestors(scan.frame, scan.scan.stamp)) {
    if (is_called(above.name, options_.base_frame)) return std::move(above);
  }
  return std::nullopt;
}

void ScanAssembler::move_ready(Clock::time_point now) {
  while (!waiting_.empty()) {
    const Waiting& waiting = waiting_.front();
    const bool is_late = now - waiting.received >= kMaxWait;
    const auto base = find_base(waiting.message);
    if (!base || !base->T_ancestor_frame) {
      if (is_late) {
        problem_ = "no transform from " + options_.base_frame + " to " + waiting.message.frame +
                   ", the frame of the scans";
      }
      return;
    }
    base_ = base->name;
    const auto odometry = odometry_.find(frames_, base_, waiting.message.scan.stamp);
    const bool is_final = odometry && odometry->T_odom_frame.is_final;
    if (!is_final && !is_late) return;
    finish(waiting, base->T_ancestor_frame->transform, odometry);
    waiting_.pop_front();
  }
}

void ScanAssembler::finish(const Waiting& waiting, const Eigen::Isometry3d& T_base_laser,
                           const std::optional<RobotOdometry::Found>& odometry) {
  const double upright = uprightness(T_base_laser);
  if (std::abs(upright) < kLeastUpright) {
    problem_ = "the laser is tilted by " + std::to_string(std::acos(upright)) + " rad against " +
               base_ + ", at most 0.43 rad can be used";
    return;
  }
  problem_.clear();
  AssembledScan out;
  out.scan = seen_from_above(waiting.message.scan, upright);
  out.time_increment = waiting.message.time_increment;
  out.T_base_link_laser = floor_pose(T_base_laser);
  if (odometry) out.T_odom_base_link = floor_pose(odometry->T_odom_frame.transform);
  out.begins_run = waiting.begins_run;
  ready_.push_back({std::move(out), waiting.received});
  if (ready_.size() > kMaxKept) {
    const bool lost_begin = ready_.front().scan.begins_run;
    ready_.pop_front();
    ready_.front().scan.begins_run |= lost_begin;
  }
}

std::vector<AssembledScan> ScanAssembler::take_batch(Clock::time_point now) {
  move_ready(now);
  if (ready_.empty()) return {};
  // The motion during a scan is known from a second one in the same request.
  const bool needs_two = ready_.front().scan.time_increment != 0.0;
  if (needs_two && ready_.size() < 2 && now - ready_.front().received < kMaxWait) return {};
  std::vector<AssembledScan> batch;
  while (!ready_.empty() && batch.size() < kMaxBatch) {
    AssembledScan& next = ready_.front().scan;
    if (!batch.empty() && (next.begins_run || !have_one_lidar(batch.front(), next))) break;
    batch.push_back(std::move(next));
    ready_.pop_front();
  }
  return batch;
}

std::optional<ScanAssembler::Clock::time_point> ScanAssembler::next_deadline() const {
  std::optional<Clock::time_point> deadline;
  if (!ready_.empty()) {
    deadline = ready_.front().received + kMaxWait;
  } else if (!waiting_.empty()) {
    deadline = waiting_.front().received + kMaxWait;
  }
  return deadline;
}

std::string ScanAssembler::odom_frame() const {
  const double stamp = last_stamp_.value_or(0.0);
  for (const FrameTree::Ancestor& above : frames_.ancestors(base_, stamp)) {
    if (is_called(above.name, "odom")) return above.name;
  }
  return odometry_.parent();
}

}  // namespace cornerfix::ros2
