#include "evaluation/datasets/bag/bag_survey.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "evaluation/datasets/bag/topic_names.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kSurveySeconds = 30.0;
constexpr std::size_t kMessagesLookedAt = 5;  // of each topic
constexpr std::size_t kFewBeams = 16;
constexpr double kWideView = 100.0 / 180.0 * std::numbers::pi;  // [rad]
constexpr double kLateSeconds = 1.0;
constexpr std::size_t kMostStaticTransforms = 1000;

bool is_scan(MessageKind kind) {
  return kind == MessageKind::kLaserScan || kind == MessageKind::kMultiEchoScan;
}

bool gives_scans(MessageKind kind) { return is_scan(kind) || kind == MessageKind::kPointCloud; }

void look_at_stamp(double stamp, double received, SurveyedTopic& topic) {
  if (stamp != 0.0 && !topic.clock_lead_s) topic.clock_lead_s = received - stamp;
}

/// Ignores messages that cannot be read.
void look_at_scan(const RecordedMessage& message, SurveyedTopic& topic) {
  if (message.kind == MessageKind::kPointCloud) {
    const auto cloud = parse_point_cloud(message.bytes, message.format);
    if (!cloud) return;
    topic.beams = std::max(topic.beams, cloud->points.size());
    look_at_stamp(cloud->stamp, message.received, topic);
    return;
  }
  const auto scan = message.kind == MessageKind::kLaserScan
                        ? parse_laser_scan(message.bytes, message.format)
                        : parse_multi_echo_scan(message.bytes, message.format);
  if (!scan) return;
  look_at_stamp(scan->scan.stamp, message.received, topic);
  const std::size_t beams = scan->scan.ranges.size();
  topic.beams = std::max(topic.beams, beams);
  topic.field_of_view = std::max(topic.field_of_view,
                                 std::abs(scan->scan.angle_increment) * static_cast<double>(beams));
}

SurveyedTopics of_kind(const SurveyedTopics& survey, MessageKind kind) {
  SurveyedTopics topics;
  std::ranges::copy_if(survey, std::back_inserter(topics),
                       [&](const SurveyedTopic& topic) { return topic.kind == kind; });
  return topics;
}

/// The names of all but those in use.
std::string others(const SurveyedTopics& topics, std::initializer_list<std::string> in_use) {
  std::string text;
  for (const SurveyedTopic& topic : topics) {
    if (std::ranges::find(in_use, topic.name) != in_use.end()) continue;
    text += (text.empty() ? "" : ", ") + topic.name;
  }
  return text;
}

std::string choose_scans(const SurveyedTopics& survey) {
  const auto rank = [](const SurveyedTopic& topic) {
    const bool is_lidar = is_scan(topic.kind) && topic.beams >= kFewBeams;
    const bool is_cloud = topic.kind == MessageKind::kPointCloud && topic.beams > 0;
    const bool is_wide = is_lidar && topic.field_of_view >= kWideView;
    return std::tuple(gives_scans(topic.kind), is_lidar, is_wide, is_cloud, topic.beams);
  };
  const auto best = std::ranges::max_element(survey, {}, rank);
  return best == survey.end() || !gives_scans(best->kind) ? std::string() : best->name;
}

/// The topic whose namespace encloses the scans most nearly.
std::optional<std::string> choose_transforms(const SurveyedTopics& survey, bool wants_static,
                                             const std::string& scans) {
  SurveyedTopics known = of_kind(survey, MessageKind::kTransforms);
  std::erase_if(known, [&](const SurveyedTopic& t) { return is_static(t.name) != wants_static; });
  const auto nearest = std::ranges::max_element(
      known, {}, [&](const SurveyedTopic& topic) { return nearness(topic.name, scans); });
  if (nearest == known.end()) return std::nullopt;
  return nearness(nearest->name, scans) || known.size() == 1 ? nearest->name : "";
}

std::optional<std::string> choose_odometry(const SurveyedTopics& survey, const std::string& scans) {
  const SurveyedTopics known = of_kind(survey, MessageKind::kOdometry);
  const auto best = std::ranges::max_element(known, {}, [&](const SurveyedTopic& topic) {
    return std::tuple(nearness(topic.name, scans), base_name(topic.name) == "odom", topic.messages);
  });
  return best == known.end() ? std::nullopt : std::optional(best->name);
}

/// Nothing where the scans are stamped by the clock of the recording.
double clock_lead_of(const std::string& scans, const SurveyedTopics& survey) {
  constexpr double kOneClock = 60.0;  // [s]
  const auto topic = std::ranges::find(survey, scans, &SurveyedTopic::name);
  const double lead = topic == survey.end() ? 0.0 : topic->clock_lead_s.value_or(0.0);
  return std::abs(lead) < kOneClock ? 0.0 : lead;
}

/// The topic that a user means, who may leave out the slash in front.
std::string topic_called(const std::string& name, const SurveyedTopics& survey) {
  const bool is_known = std::ranges::find(survey, name, &SurveyedTopic::name) != survey.end();
  const std::string with_slash = "/" + name;
  const bool has_slash =
      std::ranges::find(survey, with_slash, &SurveyedTopic::name) != survey.end();
  return !is_known && has_slash ? with_slash : name;
}

// What was chosen, where there was a choice.

void note_scans(const SurveyedTopics& survey, BagTopics& topics) {
  SurveyedTopics known = survey;
  std::erase_if(known, [](const SurveyedTopic& topic) { return !gives_scans(topic.kind); });
  const std::string unused = others(known, {topics.scans});
  const bool is_known = std::ranges::find(known, topics.scans, &SurveyedTopic::name) != known.end();
  if (!is_known || unused.empty()) return;
  topics.notes.push_back("scans of " + topics.scans + " only, not of " + unused);
}

void note_odometry(const SurveyedTopics& survey, BagTopics& topics) {
  const std::string used = topics.odometry.value_or("");
  const std::string unused = others(of_kind(survey, MessageKind::kOdometry), {used});
  if (unused.empty()) return;
  topics.notes.push_back("odometry of " + used + " where tf has none, not of " + unused +
                         "; --odom chooses");
}

/// Of a topic that was chosen but is not there.
void note_missing_odometry_topic(const SurveyedTopics& survey, BagTopics& topics) {
  const SurveyedTopics known = of_kind(survey, MessageKind::kOdometry);
  const std::string& used = *topics.odometry;
  if (std::ranges::find(known, used, &SurveyedTopic::name) != known.end()) return;
  const std::string there = others(known, {});
  topics.notes.push_back("no nav_msgs/Odometry of " + used + " (--odom), " +
                         (there.empty() ? "nor of any other topic" : "only of " + there));
}

void note_transforms(const SurveyedTopics& survey, BagTopics& topics) {
  const std::string used = topics.transforms.value_or("");
  const std::string used_static = topics.static_transforms.value_or("");
  const std::string unused = others(of_kind(survey, MessageKind::kTransforms), {used, used_static});
  if (!unused.empty()) topics.notes.push_back("no transforms of " + unused);
}

/// Looks at the messages of a bag one after the other.
class Surveyor {
 public:
  /// False when enough is known.
  bool look_at(const RecordedMessage& message) {
    SurveyedTopic& topic = topic_of(message);
    look_at_time(topic, message.received);
    ++topic.messages;
    if (is_static(topic.name)) note_static_transforms(topic, message);
    has_motion_ = has_motion_ || topic.kind == MessageKind::kOdometry ||
                  (topic.kind == MessageKind::kTransforms && !is_static(topic.name));
    if (!gives_scans(topic.kind)) return true;
    if (topic.messages <= kMessagesLookedAt) look_at_scan(message, topic);
    if (!first_scan_) first_scan_ = message.received;
    return !has_motion_ || goes_back_ || message.received <= *first_scan_ + kSurveySeconds;
  }

  [[nodiscard]] BagSurvey result() && {
    return {std::move(topics_), goes_back_ && !topic_goes_back_};
  }

 private:
  SurveyedTopic& topic_of(const RecordedMessage& message) {
    const auto known = std::ranges::find(topics_, message.topic, &SurveyedTopic::name);
    if (known != topics_.end()) return *known;
    last_received_.push_back(message.received);
    return topics_.emplace_back(SurveyedTopic{message.topic, message.kind});
  }

  /// A clock that was set back goes back in a topic as well.
  void look_at_time(const SurveyedTopic& topic, double received) {
    double& last = last_received_[static_cast<std::size_t>(&topic - topics_.data())];
    topic_goes_back_ = topic_goes_back_ || received < last - kLateSeconds;
    goes_back_ = goes_back_ || received < latest_ - kLateSeconds;
    last = received;
    latest_ = std::max(latest_, received);
  }

  static void note_static_transforms(SurveyedTopic& topic, const RecordedMessage& message) {
    const auto message_read = parse_transforms(message.bytes, message.format);
    if (!message_read || topic.static_transforms.size() > kMostStaticTransforms) return;
    std::ranges::copy(message_read->transforms, std::back_inserter(topic.static_transforms));
  }

  SurveyedTopics topics_;
  std::vector<double> last_received_;  ///< Of `topics_` [s].
  double latest_ = -std::numeric_limits<double>::infinity();
  bool goes_back_ = false;
  bool topic_goes_back_ = false;
  bool has_motion_ = false;  ///< tf or odometry.
  std::optional<double> first_scan_;
};

}  // namespace

BagSurvey survey_bag(MessageSource& messages) {
  Surveyor surveyor;
  LogFaults ignored;  // They are counted when the bag is read.
  while (const auto message = messages.next(ignored)) {
    if (!surveyor.look_at(*message)) break;
  }
  return std::move(surveyor).result();
}

bool is_static(const std::string& transforms_topic) { return transforms_topic.ends_with("static"); }

BagTopics choose_topics(const BagSurvey& survey, const LogSelection& selection) {
  const SurveyedTopics& known = survey.topics;
  BagTopics topics;
  topics.scans =
      selection.lidar.empty() ? choose_scans(known) : topic_called(selection.lidar, known);
  topics.odometry = selection.odometry.empty() ? choose_odometry(known, topics.scans)
                                               : topic_called(selection.odometry, known);
  topics.transforms = choose_transforms(known, false, topics.scans);
  topics.static_transforms = choose_transforms(known, true, topics.scans);
  const auto fixed =
      std::ranges::find(known, topics.static_transforms.value_or(""), &SurveyedTopic::name);
  if (fixed != known.end()) topics.known_static_transforms = fixed->static_transforms;
  topics.clock_lead_s = clock_lead_of(topics.scans, known);
  topics.is_out_of_order = survey.is_out_of_order;
  note_scans(known, topics);
  if (selection.odometry.empty()) {
    note_odometry(known, topics);
  } else {
    note_missing_odometry_topic(known, topics);
  }
  note_transforms(known, topics);
  return topics;
}

}  // namespace cornerfix::evaluation
