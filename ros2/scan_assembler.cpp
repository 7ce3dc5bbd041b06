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
constexpr double kSilentSeconds = 1.0;  ///< A lidar that is further behind is not waited for.
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

/// "front.scan: " before what concerns one of several lidars.
std::string prefix_of(const std::string& lidar) { return lidar.empty() ? "" : lidar + ": "; }

}  // namespace

ScanAssembler::ScanAssembler(Options options) : options_(std::move(options)) {
  for (const std::string& name : options_.lidars) lidars_.emplace_back().name = name;
}

void ScanAssembler::add_scan(ReceivedScan scan, Clock::time_point now, std::size_t lidar) {
  Lidar& source = lidars_[lidar];
  cut_to_full_turn(scan.scan);
  if (const auto error = validate(scan.scan)) {
    source.problem = "a scan that no lidar makes: " + error->field + " " + error->message;
    return;
  }
  if (!accept_stamp(source, scan.scan.stamp)) return;
  source.waiting.push_back({std::move(scan), now});
  if (source.waiting.size() > kMaxKept) source.waiting.pop_front();
}

void ScanAssembler::add_odometry(const std::optional<StampedTransform>& T_odom_child) {
  is_odometry_broken_ = !T_odom_child;
  if (T_odom_child) odometry_.add(*T_odom_child);
}

bool ScanAssembler::accept_stamp(Lidar& lidar, double stamp) {
  if (lidar.last_stamp && stamp < *lidar.last_stamp - kSetBackSeconds) begin_run(stamp);
  const double least = (1.0 - kPeriodTolerance) / options_.max_rate_hz;
  if (lidar.last_stamp && stamp - *lidar.last_stamp < least) return false;
  lidar.last_stamp = stamp;
  return true;
}

void ScanAssembler::begin_run(double stamp) {
  for (Lidar& lidar : lidars_) {
    if (!lidar.last_stamp || *lidar.last_stamp <= stamp) continue;
    lidar.waiting.clear();
    lidar.last_stamp.reset();
    lidar.last_ready.reset();
  }
  ready_.clear();
  last_taken_.reset();
  begins_run_ = true;
}

std::optional<FrameTree::Ancestor> ScanAssembler::find_base(const ReceivedScan& scan) const {
  for (FrameTree::Ancestor& above : frames_.ancestors(scan.frame, scan.scan.stamp)) {
    if (is_called(above.name, options_.base_frame)) return std::move(above);
  }
  return std::nullopt;
}

void ScanAssembler::move_ready(Lidar& lidar, Clock::time_point now) {
  while (!lidar.waiting.empty()) {
    const Waiting& waiting = lidar.waiting.front();
    const bool is_late = now - waiting.received >= kMaxWait;
    const auto base = find_base(waiting.message);
    if (!base || !base->T_ancestor_frame) {
      if (is_late) {
        lidar.problem = "no transform from " + options_.base_frame + " to " +
                        waiting.message.frame + ", the frame of the scans";
      }
      return;
    }
    base_ = base->name;
    const auto odometry = odometry_.find(frames_, base_, waiting.message.scan.stamp);
    const bool is_final = odometry && odometry->T_odom_frame.is_final;
    if (!is_final && !is_late) return;
    finish(lidar, waiting, base->T_ancestor_frame->transform, odometry);
    lidar.waiting.pop_front();
  }
}

void ScanAssembler::finish(Lidar& lidar, const Waiting& waiting,
                           const Eigen::Isometry3d& T_base_laser,
                           const std::optional<RobotOdometry::Found>& odometry) {
  const double stamp = waiting.message.scan.stamp;
  if (last_taken_ && stamp < *last_taken_) {
    lidar.problem = "scans come later than those of the other lidars: compare their stamps";
    return;
  }
  const double upright = uprightness(T_base_laser);
  if (std::abs(upright) < kLeastUpright) {
    lidar.problem = "the laser is tilted by " + std::to_string(std::acos(upright)) +
                    " rad against " + base_ + ", at most 0.43 rad can be used";
    return;
  }
  lidar.problem.clear();
  lidar.last_ready = stamp;
  AssembledScan out;
  out.lidar = lidar.name;
  out.scan = seen_from_above(waiting.message.scan, upright);
  out.time_increment = waiting.message.time_increment;
  out.T_base_link_laser = floor_pose(T_base_laser);
  if (odometry) out.T_odom_base_link = floor_pose(odometry->T_odom_frame.transform);
  insert({std::move(out), waiting.received});
}

void ScanAssembler::insert(Ready ready) {
  const auto place = std::ranges::upper_bound(
      ready_, ready.scan.scan.stamp, {}, [](const Ready& each) { return each.scan.scan.stamp; });
  ready_.insert(place, std::move(ready));
  if (ready_.size() > kMaxKept * lidars_.size()) ready_.pop_front();
}

bool ScanAssembler::is_complete(const Ready& ready, Clock::time_point now) const {
  if (now - ready.received >= kMaxWait) return true;
  const double stamp = ready.scan.scan.stamp;
  return std::ranges::all_of(lidars_, [&](const Lidar& lidar) {
    return is_silent(lidar) || (lidar.last_ready && *lidar.last_ready >= stamp);
  });
}

std::size_t ScanAssembler::count_complete(Clock::time_point now) const {
  const auto end =
      std::ranges::find_if_not(ready_, [&](const Ready& ready) { return is_complete(ready, now); });
  return std::min(static_cast<std::size_t>(end - ready_.begin()), kMaxBatch);
}

bool ScanAssembler::lacks_motion(std::size_t count) const {
  const auto end = ready_.begin() + static_cast<std::ptrdiff_t>(count);
  return std::any_of(ready_.begin(), end, [&](const Ready& ready) {
    const auto is_same_lidar = [&](const Ready& other) {
      return other.scan.lidar == ready.scan.lidar;
    };
    return ready.scan.time_increment != 0.0 &&
           std::count_if(ready_.begin(), end, is_same_lidar) < 2;
  });
}

std::vector<AssembledScan> ScanAssembler::take_batch(Clock::time_point now) {
  for (Lidar& lidar : lidars_) move_ready(lidar, now);
  const std::size_t count = count_complete(now);
  if (count == 0) return {};
  const bool is_late = now - ready_.front().received >= kMaxWait;
  if (!is_late && lacks_motion(count)) return {};
  std::vector<AssembledScan> batch;
  for (std::size_t i = 0; i < count; ++i) {
    batch.push_back(std::move(ready_.front().scan));
    ready_.pop_front();
  }
  batch.front().begins_run = std::exchange(begins_run_, false);
  last_taken_ = batch.back().scan.stamp;
  return batch;
}

std::optional<ScanAssembler::Clock::time_point> ScanAssembler::next_deadline(
    Clock::time_point now) const {
  std::optional<Clock::time_point> deadline;
  const auto consider = [&](Clock::time_point received) {
    const auto end = received + kMaxWait;
    if (end > now && (!deadline || end < *deadline)) deadline = end;
  };
  for (const Ready& ready : ready_) consider(ready.received);
  for (const Lidar& lidar : lidars_) {
    if (!lidar.waiting.empty()) consider(lidar.waiting.front().received);
  }
  return deadline;
}

double ScanAssembler::newest_stamp() const {
  std::optional<double> newest;
  for (const Lidar& lidar : lidars_) newest = std::max(newest, lidar.last_stamp);
  return newest.value_or(0.0);
}

bool ScanAssembler::is_silent(const Lidar& lidar) const {
  return !lidar.last_stamp || *lidar.last_stamp < newest_stamp() - kSilentSeconds;
}

std::string ScanAssembler::problem() const {
  for (const Lidar& lidar : lidars_) {
    if (!lidar.problem.empty()) return prefix_of(lidar.name) + lidar.problem;
  }
  if (is_odometry_broken_) {
    return "odometry without a pose: its position must be finite, its orientation a unit "
           "quaternion";
  }
  const bool has_scans =
      std::ranges::any_of(lidars_, [](const Lidar& lidar) { return lidar.last_stamp.has_value(); });
  if (!has_scans) return "";
  for (const Lidar& lidar : lidars_) {
    if (is_silent(lidar)) return prefix_of(lidar.name) + "no scans";
  }
  return "";
}

std::string ScanAssembler::odom_frame() const {
  for (const FrameTree::Ancestor& above : frames_.ancestors(base_, newest_stamp())) {
    if (is_called(above.name, "odom")) return above.name;
  }
  return odometry_.parent();
}

}  // namespace cornerfix::ros2
