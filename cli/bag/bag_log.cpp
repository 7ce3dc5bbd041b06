#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <utility>

#include "cli/bag/frame_tree.hpp"
#include "cli/bag/mcap.hpp"
#include "cli/bag/message_source.hpp"
#include "cli/bag/ros1_bag.hpp"
#include "cli/bag/sqlite_bag.hpp"
#include "cli/log_source.hpp"

namespace cornerfix::cli {

namespace {

/// A scan waits for transforms of its time this long, by the clock of the recording.
constexpr double kMaxWaitSeconds = 1.0;
constexpr std::size_t kMaxWaiting = 256;

/// The laser's z axis must be within 25 degrees of the vertical.
const double kLeastUpright = std::cos(25.0 * std::numbers::pi / 180.0);

struct WaitingScan {
  LaserScanMessage message;
  double received = 0.0;
  std::string where;
};

/// Seen from above: an overhead lidar turns clockwise.
LaserScan turned_over(LaserScan scan) {
  const auto last = static_cast<double>(scan.ranges.size() - 1);
  scan.angle_min = -(scan.angle_min + last * scan.angle_increment);
  std::reverse(scan.ranges.begin(), scan.ranges.end());
  return scan;
}

/// Position and heading of the x axis, seen from above.
Pose2 on_the_floor(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T(1, 0), T(0, 0))};
}

/// How upright the laser stands: 1, or -1 when it hangs upside down.
double uprightness(const Eigen::Isometry3d& T) { return T(2, 2); }

/// Scans of one lidar with the poses that odometry and tf know for them.
class BagLog final : public LogSource {
 public:
  BagLog(std::unique_ptr<MessageSource> messages, std::string topic)
      : messages_(std::move(messages)), topic_(std::move(topic)) {}

  std::optional<LogScan> next(LogFaults& faults) override {
    while (true) {
      if (!waiting_.empty() && is_ready(waiting_.front())) {
        const WaitingScan scan = std::move(waiting_.front());
        waiting_.pop_front();
        if (auto finished = finish(scan, faults)) return finished;
      } else if (is_at_end_) {
        return std::nullopt;
      } else if (const auto message = messages_->next(faults)) {
        take(*message, faults);
      } else {
        is_at_end_ = true;
      }
    }
  }

  [[nodiscard]] double progress() const override { return messages_->progress(); }

 private:
  void take(const RecordedMessage& message, LogFaults& faults) {
    now_ = message.received;
    switch (message.kind) {
      case MessageKind::kLaserScan:
        return take_scan(message, faults);
      case MessageKind::kOdometry:
        return take_odometry(message, faults);
      case MessageKind::kTransforms:
        return take_transforms(message, faults);
    }
  }

  void take_scan(const RecordedMessage& message, LogFaults& faults) {
    if (topic_.empty()) topic_ = message.topic;
    if (message.topic != topic_) {
      if (!std::exchange(is_other_noted_, true)) {
        notes_.push_back("scans of " + topic_ + " only, not of " + message.topic);
      }
      return;
    }
    Result<LaserScanMessage> scan = parse_laser_scan(message.bytes, message.format);
    if (!scan) return faults.add_scan(message.where, scan.error().message);
    if (scan->scan.stamp == 0.0) scan->scan.stamp = message.received;
    waiting_.push_back({std::move(*scan), message.received, message.where});
  }

  void take_odometry(const RecordedMessage& message, LogFaults& faults) {
    Result<StampedTransform> odometry = parse_odometry(message.bytes, message.format);
    if (!odometry) return faults.add(message.where, odometry.error().message);
    if (odometry->child.empty()) odometry->child = "base_link";
    if (odometry->parent.find("odom") == std::string::npos) odometry->parent = "odom";
    base_frame_ = odometry->child;
    frames_.add(*odometry, FrameTree::Origin::kOdometry);
  }

  void take_transforms(const RecordedMessage& message, LogFaults& faults) {
    const auto transforms = parse_transforms(message.bytes, message.format);
    if (!transforms) return faults.add(message.where, transforms.error().message);
    const auto origin =
        message.topic.ends_with("tf_static") ? FrameTree::Origin::kStatic : FrameTree::Origin::kTf;
    for (const StampedTransform& transform : *transforms) frames_.add(transform, origin);
  }

  /// Whether what is to come can no longer tell more of the scan's place, or may not be waited for.
  [[nodiscard]] bool is_ready(const WaitingScan& scan) const {
    if (is_at_end_ || waiting_.size() > kMaxWaiting) return true;
    if (now_ - scan.received > kMaxWaitSeconds) return true;
    const auto in_map = find("map", scan);
    const auto in_odom = find("odom", scan);
    return in_map && in_map->is_final && in_odom && in_odom->is_final;
  }

  [[nodiscard]] std::optional<FrameTree::Found> find(std::string_view ancestor,
                                                     const WaitingScan& scan) const {
    return frames_.find(ancestor, scan.message.frame, scan.message.scan.stamp);
  }

  /// Odometry tells of the robot's base; without a transform from there to the laser, the laser is
  /// taken to be there.
  std::optional<FrameTree::Found> find_base_in_odom(const WaitingScan& scan) {
    if (base_frame_.empty() || frames_.knows(scan.message.frame)) return std::nullopt;
    auto found = frames_.find("odom", base_frame_, scan.message.scan.stamp);
    if (found && !std::exchange(is_mount_noted_, true)) {
      notes_.push_back("no transform from " + base_frame_ + " to " + scan.message.frame +
                       ": the laser is taken to be at " + base_frame_);
    }
    return found;
  }

  std::optional<LogScan> finish(const WaitingScan& waiting, LogFaults& faults) {
    LogScan out;
    out.scan = waiting.message.scan;
    const auto in_map = find("map", waiting);
    auto in_odom = find("odom", waiting);
    if (!in_odom) in_odom = find_base_in_odom(waiting);
    if (in_map) out.T_map_laser = on_the_floor(in_map->T_ancestor_frame);
    if (in_odom) out.T_odom_laser = on_the_floor(in_odom->T_ancestor_frame);
    const auto& in_level = in_odom ? in_odom : in_map;
    const double upright = in_level ? uprightness(in_level->T_ancestor_frame) : 1.0;
    if (std::abs(upright) < kLeastUpright) {
      faults.add_scan(waiting.where, "the laser does not look along the floor: it is tilted by " +
                                    std::to_string(std::acos(upright)) + " rad");
      return std::nullopt;
    }
    if (upright < 0.0) out.scan = turned_over(std::move(out.scan));
    if (header_.beams == 0) set_lidar(header_, out.scan);
    return out;
  }

  std::unique_ptr<MessageSource> messages_;
  std::string topic_;  ///< Of the scans; empty until the first when any will do.
  FrameTree frames_;
  std::string base_frame_;  ///< Of the odometry.
  std::deque<WaitingScan> waiting_;
  double now_ = 0.0;  ///< Of the recording [s].
  bool is_at_end_ = false;
  bool is_other_noted_ = false;
  bool is_mount_noted_ = false;
};

Result<std::unique_ptr<LogSource>> open_bag(Result<std::unique_ptr<MessageSource>> messages,
                                            const std::string& topic) {
  if (!messages) return messages.error();
  return std::unique_ptr<LogSource>(std::make_unique<BagLog>(std::move(*messages), topic));
}

}  // namespace

Result<std::unique_ptr<LogSource>> open_ros1_bag(const std::filesystem::path& path,
                                                 const std::string& lidar) {
  return open_bag(open_ros1_messages(path), lidar);
}

Result<std::unique_ptr<LogSource>> open_mcap(const std::filesystem::path& path,
                                             const std::string& lidar) {
  return open_bag(open_mcap_messages(path), lidar);
}

Result<std::unique_ptr<LogSource>> open_sqlite_bag(const std::filesystem::path& path,
                                                   const std::string& lidar) {
  return open_bag(open_sqlite_messages(path), lidar);
}

}  // namespace cornerfix::cli
