/// \file  Answers of the server as messages.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <cornerfix/result.hpp>

#include "ros2/answer.hpp"
#include "ros2/dds_node.hpp"

namespace cornerfix::ros2 {

/// A diagnostic_msgs/DiagnosticStatus.
struct Diagnosis {
  enum class Level : std::uint8_t { kOk, kWarn, kError };

  Level level = Level::kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};

struct PoseTopics {
  std::string initialpose;
  std::string tf;  ///< Empty to publish none.
  std::string diagnostics;
};

/// Not synchronised.
class PosePublisher {
 public:
  /// Publishes nothing before.
  [[nodiscard]] Result<void> open(DdsNode& node, const PoseTopics& topics);

  [[nodiscard]] bool has_pose_subscriber() const { return pose_.has_subscriber(); }

  void publish_pose(const LocalizedPose& pose, const std::string& map_frame);

  /// The transform from `map_frame` to `odom_frame`, valid for a second from the pose's stamp on,
  /// as amcl publishes it. Nothing without a topic.
  void publish_transform(const LocalizedPose& pose, const Pose2& T_odom_base_link,
                         const std::string& map_frame, const std::string& odom_frame);

  void publish_diagnosis(const Diagnosis& diagnosis, const std::string& robot);

 private:
  bool has_tf_ = false;
  Publisher<PoseMessage> pose_;
  Publisher<TfMessage> tf_;
  Publisher<DiagnosticArray> diagnostics_;
};

}  // namespace cornerfix::ros2
