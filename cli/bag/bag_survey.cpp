#include "cli/bag/bag_survey.hpp"

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <tuple>
#include <utility>

#include "cli/bag/topic_names.hpp"

namespace cornerfix::cli {

namespace {

constexpr double kSurveySeconds = 30.0;
constexpr std::size_t kMessagesLookedAt = 5;  // of each topic
constexpr std::size_t kFewBeams = 16;

bool is_scan(MessageKind kind) {
  return kind == MessageKind::kLaserScan || kind == MessageKind::kMultiEchoScan;
}

bool gives_scans(MessageKind kind) { return is_scan(kind) || kind == MessageKind::kPointCloud; }

/// 0 for what cannot be read.
std::size_t beams_of(const RecordedMessage& message) {
  if (message.kind == MessageKind::kPointCloud) {
    const auto cloud = parse_point_cloud(message.bytes, message.format);
    return cloud ? cloud->points.size() : 0;
  }
  const auto scan = message.kind == MessageKind::kLaserScan
                        ? parse_laser_scan(message.bytes, message.format)
                        : parse_multi_echo_scan(message.bytes, message.format);
  return scan ? scan->scan.ranges.size() : 0;
}

BagSurvey of_kind(const BagSurvey& survey, MessageKind kind) {
  BagSurvey topics;
  std::ranges::copy_if(survey, std::back_inserter(topics),
                       [&](const SurveyedTopic& topic) { return topic.kind == kind; });
  return topics;
}

/// The names of all but those in use.
std::string others(const BagSurvey& topics, std::initializer_list<std::string> in_use) {
  std::string text;
  for (const SurveyedTopic& topic : topics) {
    if (std::ranges::find(in_use, topic.name) != in_use.end()) continue;
    text += (text.empty() ? "" : ", ") + topic.name;
  }
  return text;
}

std::string choose_scans(const BagSurvey& survey) {
  const auto rank = [](const SurveyedTopic& topic) {
    const bool is_lidar = is_scan(topic.kind) && topic.beams >= kFewBeams;
    const bool is_cloud = topic.kind == MessageKind::kPointCloud && topic.beams > 0;
    return std::tuple(gives_scans(topic.kind), is_lidar, is_cloud, topic.beams);
  };
  const auto best = std::ranges::max_element(survey, {}, rank);
  return best == survey.end() || !gives_scans(best->kind) ? std::string() : best->name;
}

/// The topic whose namespace encloses the scans most nearly.
std::optional<std::string> choose_transforms(const BagSurvey& survey, bool wants_static,
                                             const std::string& scans) {
  BagSurvey known = of_kind(survey, MessageKind::kTransforms);
  std::erase_if(known, [&](const SurveyedTopic& t) { return is_static(t.name) != wants_static; });
  const auto nearest = std::ranges::max_element(
      known, {}, [&](const SurveyedTopic& topic) { return nearness(topic.name, scans); });
  if (nearest == known.end()) return std::nullopt;
  return nearness(nearest->name, scans) || known.size() == 1 ? nearest->name : "";
}

std::optional<std::string> choose_odometry(const BagSurvey& survey, const std::string& scans) {
  const BagSurvey known = of_kind(survey, MessageKind::kOdometry);
  const auto best = std::ranges::max_element(known, {}, [&](const SurveyedTopic& topic) {
    return std::tuple(nearness(topic.name, scans), base_name(topic.name) == "odom", topic.messages);
  });
  return best == known.end() ? std::nullopt : std::optional(best->name);
}

// What was chosen, where there was a choice.

void note_scans(const BagSurvey& survey, BagTopics& topics) {
  BagSurvey known = survey;
  std::erase_if(known, [](const SurveyedTopic& topic) { return !gives_scans(topic.kind); });
  const std::string unused = others(known, {topics.scans});
  if (known.empty() || unused.empty()) return;
  topics.notes.push_back("scans of " + topics.scans + " only, not of " + unused);
}

void note_odometry(const BagSurvey& survey, BagTopics& topics) {
  const std::string used = topics.odometry.value_or("");
  const std::string unused = others(of_kind(survey, MessageKind::kOdometry), {used});
  if (unused.empty()) return;
  topics.notes.push_back("odometry of " + used + " where tf has none, not of " + unused +
                         "; --odom chooses");
}

void note_transforms(const BagSurvey& survey, BagTopics& topics) {
  const std::string used = topics.transforms.value_or("");
  const std::string used_static = topics.static_transforms.value_or("");
  const std::string unused = others(of_kind(survey, MessageKind::kTransforms), {used, used_static});
  if (!unused.empty()) topics.notes.push_back("no transforms of " + unused);
}

}  // namespace

BagSurvey survey_bag(MessageSource& messages) {
  BagSurvey survey;
  LogFaults ignored;  // They are counted when the bag is read.
  std::optional<double> first_scan;
  while (const auto message = messages.next(ignored)) {
    auto known = std::ranges::find(survey, message->topic, &SurveyedTopic::name);
    if (known == survey.end()) known = survey.insert(known, {message->topic, message->kind, 0, 0});
    SurveyedTopic& topic = *known;
    ++topic.messages;
    if (!gives_scans(topic.kind)) continue;
    if (topic.messages <= kMessagesLookedAt)
      topic.beams = std::max(topic.beams, beams_of(*message));
    if (!first_scan) first_scan = message->received;
    if (message->received > *first_scan + kSurveySeconds) break;
  }
  return survey;
}

bool is_static(const std::string& transforms_topic) { return transforms_topic.ends_with("static"); }

BagTopics choose_topics(const BagSurvey& survey, const LogSelection& selection) {
  BagTopics topics;
  topics.scans = selection.lidar.empty() ? choose_scans(survey) : selection.lidar;
  topics.odometry =
      selection.odometry.empty() ? choose_odometry(survey, topics.scans) : selection.odometry;
  topics.transforms = choose_transforms(survey, false, topics.scans);
  topics.static_transforms = choose_transforms(survey, true, topics.scans);
  note_scans(survey, topics);
  if (selection.odometry.empty()) note_odometry(survey, topics);
  note_transforms(survey, topics);
  return topics;
}

}  // namespace cornerfix::cli
