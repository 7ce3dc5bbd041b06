#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <limits>
#include <set>
#include <utility>

#include "evaluation/datasets/bag/bag_messages.hpp"
#include "evaluation/datasets/bag/bag_survey.hpp"
#include "evaluation/datasets/bag/point_cloud_slice.hpp"
#include "evaluation/datasets/bag/separated_stamps.hpp"
#include "evaluation/datasets/bag/sorted_messages.hpp"
#include "evaluation/datasets/bag/stamp_range.hpp"
#include "evaluation/datasets/log_source.hpp"
#include "evaluation/datasets/scan_limits.hpp"
#include "frames/floor_pose.hpp"
#include "frames/frame_tree.hpp"
#include "frames/robot_odometry.hpp"

namespace cornerfix::evaluation {

namespace {

/// A scan waits for transforms of its time this long, by the clock of the recording.
constexpr double kMaxWaitSeconds = 1.0;
constexpr std::size_t kMaxWaiting = 256;

/// After as many scans without any odometry people should know.
constexpr std::size_t kScansWithoutOdometry = 20;

struct WaitingScan {
  LaserScanMessage message;
  double received = 0.0;
  std::string where;
  bool is_level = false;  ///< However the sensor stands.
};

/// Seen from above: an overhead lidar turns clockwise.
LaserScan turned_over(LaserScan scan) {
  const auto last = static_cast<double>(scan.ranges.size() - 1);
  scan.angle_min = -(scan.angle_min + last * scan.angle_increment);
  std::reverse(scan.ranges.begin(), scan.ranges.end());
  return scan;
}

/// "/scan (sensor_msgs/LaserScan, 120 messages), ..."
std::string list(const std::vector<BagTopic>& topics) {
  constexpr std::size_t kMostListed = 30;
  if (topics.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < std::min(topics.size(), kMostListed); ++i) {
    text += (i == 0 ? "" : ", ") + topics[i].name + " (" + topics[i].type + ", " +
            std::to_string(topics[i].messages) + " messages)";
  }
  if (topics.size() > kMostListed) {
    text += " and " + std::to_string(topics.size() - kMostListed) + " more";
  }
  return text;
}

/// Scans of one lidar with the poses that odometry and tf know for them.
class BagLog final : public LogSource {
 public:
  BagLog(std::unique_ptr<MessageSource> messages, BagTopics topics, const LogSelection& selection)
      : messages_(std::move(messages)),
        topics_(std::move(topics)),
        height_(selection.height),
        odometry_(!selection.odometry.empty()) {
    notes_ = std::move(topics_.notes);
    for (const StampedTransform& transform : topics_.known_static_transforms) {
      frames_.add(transform, FrameTree::Origin::kStatic);
    }
  }

  std::optional<LogScan> next(LogFaults& faults) override {
    while (true) {
      if (!waiting_.empty() && is_ready(waiting_.front())) {
        const WaitingScan scan = std::move(waiting_.front());
        waiting_.pop_front();
        if (auto finished = finish(scan, faults)) return finished;
      } else if (is_at_end_) {
        note_missing_odometry();
        return std::nullopt;
      } else if (const auto message = messages_->next(faults)) {
        take(*message, faults);
      } else {
        end();
      }
    }
  }

  [[nodiscard]] double progress() const override { return messages_->progress(); }

 private:
  void take(const RecordedMessage& message, LogFaults& faults) {
    now_ = message.received;
    switch (message.kind) {
      case MessageKind::kLaserScan:
      case MessageKind::kMultiEchoScan:
        if (message.topic == topics_.scans) take_scan(message, faults);
        return;
      case MessageKind::kPointCloud:
        if (message.topic == topics_.scans) take_cloud(message, faults);
        return;
      case MessageKind::kOdometry:
        if (is_in_use(message.topic, topics_.odometry)) take_odometry(message, faults);
        return;
      case MessageKind::kTransforms:
        return take_transforms(message, faults);
    }
  }

  /// The first topic that comes is taken where there was none to choose from.
  static bool is_in_use(const std::string& topic, std::optional<std::string>& chosen) {
    if (!chosen) chosen = topic;
    return topic == *chosen;
  }

  void take_scan(const RecordedMessage& message, LogFaults& faults) {
    Result<LaserScanMessage> scan = message.kind == MessageKind::kLaserScan
                                        ? parse_laser_scan(message.bytes, message.format)
                                        : parse_multi_echo_scan(message.bytes, message.format);
    if (!scan) return faults.add_scan(message.where, scan.error().message);
    wait(message, std::move(*scan), false);
  }

  void take_cloud(const RecordedMessage& message, LogFaults& faults) {
    const Result<PointCloudMessage> cloud = parse_point_cloud(message.bytes, message.format);
    if (!cloud) return faults.add_scan(message.where, cloud.error().message);
    if (!std::exchange(is_slice_noted_, true)) note_slice();
    const auto above = frames_.ancestors(cloud->frame, cloud->stamp);
    const auto highest = std::find_if(
        above.rbegin(), above.rend(),
        [](const FrameTree::Ancestor& ancestor) { return ancestor.T_ancestor_frame.has_value(); });
    const Eigen::Matrix3d rotation = highest->T_ancestor_frame->transform.rotation();
    wait(message, {cloud->frame, slice(*cloud, rotation, height_)}, true);
  }

  void wait(const RecordedMessage& message, LaserScanMessage scan, bool is_level) {
    if (!is_of_the_lidar(scan.frame, message.received)) return;
    if (scan.scan.stamp == 0.0) scan.scan.stamp = message.received - topics_.clock_lead_s;
    separated_.place(scan.scan, message.received);
    scan_stamps_.add(scan.scan.stamp);
    waiting_.push_back({std::move(scan), message.received, message.where, is_level});
  }

  /// Two lidars may publish on one topic, each in its frame. The one that came first is taken; when
  /// it comes no more, its frame may have got another name.
  bool is_of_the_lidar(const std::string& frame, double received) {
    constexpr double kGoneSeconds = 2.0;
    const bool is_other = !frame.empty() && !lidar_frame_.empty() && frame != lidar_frame_;
    if (is_other && std::abs(received - lidar_seen_) <= kGoneSeconds) {
      note_other_frame(frame);
      return false;
    }
    if (!frame.empty()) lidar_frame_ = frame;
    lidar_seen_ = received;
    return true;
  }

  /// "scans of /scan in the frame front only, not in rear"
  void note_other_frame(const std::string& frame) {
    constexpr std::size_t kMostNotes = 10;
    if (other_frames_.size() == kMostNotes || !other_frames_.insert(frame).second) return;
    notes_.push_back("scans of " + topics_.scans + " in the frame " + lidar_frame_ +
                     " only, not in " + frame + ": expected one lidar per topic");
  }

  void take_odometry(const RecordedMessage& message, LogFaults& faults) {
    Result<StampedTransform> odometry = parse_odometry(message.bytes, message.format);
    if (!odometry) return faults.add(message.where, odometry.error().message);
    if (odometry->stamp == 0.0) odometry->stamp = message.received;
    odometry_.add(*odometry);
    odometry_stamps_.add(odometry->stamp);
  }

  void take_transforms(const RecordedMessage& message, LogFaults& faults) {
    const bool holds_always = is_static(message.topic);
    if (!is_in_use(message.topic, holds_always ? topics_.static_transforms : topics_.transforms)) {
      return;
    }
    auto read = parse_transforms(message.bytes, message.format);
    if (!read) return faults.add(message.where, read.error().message);
    if (!read->fault.empty()) faults.add(message.where, read->fault);
    for (StampedTransform& transform : read->transforms) {
      if (transform.stamp == 0.0) transform.stamp = message.received;
      frames_.add(transform, holds_always ? FrameTree::Origin::kStatic : FrameTree::Origin::kTf);
      if (!holds_always) transform_stamps_.add(transform.stamp);
    }
  }

  /// Whether what is to come cannot change the pose of the scan, or may not be waited for. The
  /// clock of the recording may have been set back, or stand still.
  [[nodiscard]] bool is_ready(const WaitingScan& scan) const {
    if (is_at_end_ || waiting_.size() > kMaxWaiting) return true;
    if (std::abs(now_ - scan.received) > kMaxWaitSeconds) return true;
    const double newest_stamp = waiting_.back().message.scan.stamp;
    if (std::abs(newest_stamp - scan.message.scan.stamp) > kMaxWaitSeconds) return true;
    const auto in_map = find_in_map(scan);
    const auto in_odom = find_in_odom(scan);
    return in_map && in_map->is_final && in_odom && in_odom->T_odom_frame.is_final;
  }

  [[nodiscard]] std::optional<FoundTransform> find_in_map(const WaitingScan& scan) const {
    return frames_.find("map", scan.message.frame, scan.message.scan.stamp);
  }

  [[nodiscard]] std::optional<RobotOdometry::Found> find_in_odom(const WaitingScan& scan) const {
    return odometry_.find(frames_, scan.message.frame, scan.message.scan.stamp);
  }

  std::optional<LogScan> finish(const WaitingScan& waiting, LogFaults& faults) {
    LogScan out;
    out.scan = waiting.message.scan;
    out.time_increment = waiting.message.time_increment;
    const auto in_map = find_in_map(waiting);
    const auto in_odom = find_in_odom(waiting);
    if (in_map) out.T_map_laser = floor_pose(in_map->transform);
    if (in_odom) out.T_odom_laser = floor_pose(in_odom->T_odom_frame.transform);
    if (in_odom && !in_odom->note.empty()) note_assumption(in_odom->note);
    count_odometry(in_odom.has_value(), waiting.message.frame);
    double upright = 1.0;
    if (in_map) upright = uprightness(in_map->transform);
    if (in_odom) upright = uprightness(in_odom->T_odom_frame.transform);
    if (!waiting.is_level && std::abs(upright) < kLeastUpright) {
      faults.add_scan(waiting.where, "the laser does not look along the floor: it is tilted by " +
                                         std::to_string(std::acos(upright)) + " rad");
      return std::nullopt;
    }
    if (const auto error = find_value_beyond_limits(out)) {
      faults.add_scan(waiting.where, error->field + ": " + error->message);
      return std::nullopt;
    }
    if (!waiting.is_level && upright < 0.0) {
      out.scan = turned_over(std::move(out.scan));
      out.time_increment = -out.time_increment;
    } else {
      out.stated_angle_max = waiting.message.angle_max;
    }
    if (header_.beams == 0) set_lidar(header_, out.scan);
    return out;
  }

  void end() {
    is_at_end_ = true;
    if (std::string note = separated_.note(); !note.empty()) notes_.push_back(std::move(note));
    if (scan_stamps_.is_empty()) notes_.push_back("its topics are " + list(messages_->topics()));
  }

  void note_assumption(const std::string& note) {
    if (!std::exchange(is_assumption_noted_, true)) notes_.push_back(note);
  }

  void note_slice() {
    char band[64];
    std::snprintf(band, sizeof band, "%.2f to %.2f m", height_.min_m, height_.max_m);
    notes_.push_back("scans are cut from the point cloud " + topics_.scans + ", " + band +
                     " above the sensor; --height chooses");
  }

  /// Says why no scan has odometry once that is clear.
  void count_odometry(bool has_odometry, const std::string& frame) {
    ++finished_;
    if (!has_odometry) {
      ++without_odometry_;
      lacking_frame_ = frame;
    }
    const bool is_clear = finished_ == kScansWithoutOdometry || (is_at_end_ && waiting_.empty());
    if (without_odometry_ == finished_ && is_clear) note_lack(std::to_string(finished_));
  }

  /// Names the share of the scans that have none, where some have.
  void note_missing_odometry() {
    constexpr std::size_t kFewScans = 3;  // at the begin and the end of a bag
    if (without_odometry_ <= kFewScans || 10 * without_odometry_ <= finished_) return;
    note_lack(std::to_string(without_odometry_) + " of " + std::to_string(finished_));
  }

  void note_lack(const std::string& scans) {
    if (std::exchange(is_lack_noted_, true)) return;
    const std::string frame =
        lacking_frame_.empty() ? "without a frame_id" : "in the frame " + lacking_frame_;
    notes_.push_back("no odometry for " + scans + " scans " + frame + ", stamped " +
                     scan_stamps_.text() + "; " + known_odometry(lacking_frame_));
  }

  [[nodiscard]] std::string known_odometry(const std::string& frame) const {
    std::string text;
    if (!odometry_stamps_.is_empty()) {
      text += "messages of " + *topics_.odometry + " from " + odometry_.parent() + " to " +
              odometry_.child() + " are stamped " + odometry_stamps_.text() + "; ";
    }
    if (frame.empty()) return text + "frames cannot be connected with these scans";
    text += "frames above " + frame + ":";
    const auto above = frames_.ancestors(frame, 0.0);
    for (std::size_t i = 1; i < above.size(); ++i) text += " " + above[i].name;
    if (above.size() == 1) text += " none";
    if (transform_stamps_.is_empty()) return text + "; no transforms but static ones";
    return text + "; transforms are stamped " + transform_stamps_.text();
  }

  std::unique_ptr<MessageSource> messages_;
  BagTopics topics_;
  HeightBand height_;
  FrameTree frames_;
  RobotOdometry odometry_;
  SeparatedStamps separated_;
  std::string lidar_frame_;  ///< Of the scans that are taken.
  double lidar_seen_ = 0.0;  ///< When the last of them was recorded [s].
  std::set<std::string> other_frames_;
  std::deque<WaitingScan> waiting_;
  double now_ = 0.0;  ///< Of the recording [s].
  bool is_at_end_ = false;

  StampRange scan_stamps_;
  StampRange odometry_stamps_;
  StampRange transform_stamps_;
  std::size_t finished_ = 0;
  std::size_t without_odometry_ = 0;  ///< Of `finished_`.
  std::string lacking_frame_;         ///< Of the last scan without odometry.
  bool is_lack_noted_ = false;
  bool is_assumption_noted_ = false;
  bool is_slice_noted_ = false;
};

}  // namespace

Result<std::unique_ptr<LogSource>> open_bag(const std::filesystem::path& path,
                                            const LogSelection& selection) {
  Result<BagFiles> files = find_bag_files(path);
  if (!files) return files.error();
  const Result<std::unique_ptr<MessageSource>> looked_at = open_bag_messages(*files);
  if (!looked_at) return looked_at.error();
  BagTopics topics = choose_topics(survey_bag(**looked_at), selection);
  Result<std::unique_ptr<MessageSource>> messages = open_bag_messages(*files);
  if (!messages) return messages.error();
  topics.notes.insert(topics.notes.begin(), files->notes.begin(), files->notes.end());
  if (topics.is_out_of_order) {
    topics.notes.emplace_back("the messages are not in the order of their time: they are sorted");
    const std::set<std::string> of_use = {topics.scans, topics.odometry.value_or(""),
                                          topics.transforms.value_or(""),
                                          topics.static_transforms.value_or("")};
    *messages = sorted_by_time(std::move(*messages), [of_use](const RecordedMessage& message) {
      return of_use.contains(message.topic);
    });
  }
  return std::unique_ptr<LogSource>(
      std::make_unique<BagLog>(std::move(*messages), std::move(topics), selection));
}

}  // namespace cornerfix::evaluation
