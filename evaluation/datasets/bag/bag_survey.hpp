/// \file  What a bag holds, and which of its topics are read.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/datasets/bag/message_source.hpp"
#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// A topic of a kind of use here.
struct SurveyedTopic {
  std::string name;
  MessageKind kind = MessageKind::kLaserScan;
  std::size_t messages = 0;
  std::size_t beams = 0;  ///< Most of the messages looked at; points of a cloud; 0 for other kinds.
  double field_of_view = 0.0;  ///< The widest of the scans looked at [rad].
  std::vector<StampedTransform> static_transforms = {};  ///< The first ones.
  /// Of the recording before the first scan's stamp.
  std::optional<double> clock_lead_s = std::nullopt;
};

/// In the order of their first messages.
using SurveyedTopics = std::vector<SurveyedTopic>;

struct BagSurvey {
  SurveyedTopics topics;
  /// Messages were recorded before those in front of them, though those of each topic are in order.
  /// The bag was written topic by topic, or its files were recorded side by side.
  bool is_out_of_order = false;
};

/// Looks at a bag from its begin: until 30 s of recorded time after the first scan. To the end
/// where there was neither odometry nor tf until then, or the bag is out of order.
[[nodiscard]] BagSurvey survey_bag(MessageSource& messages);

/// The topics that a log is made from, and why these, for people.
struct BagTopics {
  std::string scans;  ///< Empty when there are none.
  // Nothing when there were none so far; empty when there is no reason to take one of several.
  std::optional<std::string> odometry;                    ///< Of nav_msgs/Odometry.
  std::optional<std::string> transforms;                  ///< "/robot1/tf".
  std::optional<std::string> static_transforms;           ///< "/robot1/tf_static".
  std::vector<StampedTransform> known_static_transforms;  ///< Of `static_transforms`.
  /// By how much the clock of the recording is ahead of the one that stamps scans, where these are
  /// two clocks: that of a simulation begins at 0 [s].
  double clock_lead_s = 0.0;
  bool is_out_of_order = false;
  std::vector<std::string> notes;
};

/// - Scans: as chosen; or else the topic of most beams, of those that see 100 degrees if there are
///   any: a depth camera has more beams than many a lidar. A point cloud is taken where no scan has
///   16.
/// - Transforms: of the nearest namespace that encloses the topic of the scans. Where none does, of
///   the only namespace that has any.
/// - Odometry: as chosen; or else of the nearest namespace; among several of one namespace `odom`,
///   then the one of most messages.
/// Whether the transforms of a topic hold at all times.
[[nodiscard]] bool is_static(const std::string& transforms_topic);

[[nodiscard]] BagTopics choose_topics(const BagSurvey& survey, const LogSelection& selection);

}  // namespace cornerfix::evaluation
