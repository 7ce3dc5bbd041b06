#include "ros2/bridge.hpp"

#include <mutex>
#include <set>
#include <utility>

#include "ros2/robot_bridge.hpp"

namespace cornerfix::ros2 {

namespace {

std::optional<Error> find_shared(const BridgeOptions& options) {
  std::set<std::string> names;
  std::set<std::string> topics;
  for (const RobotName& robot : options.robots) {
    if (!names.insert(robot.name).second) {
      return Error{ErrorCode::kInvalidArgument, "two robots have the name " + robot.name, ""};
    }
    for (const std::string& topic : options.scan_topics) {
      const std::string scan = options.remappings.resolve(topic, robot.ns);
      if (topics.insert(scan).second) continue;
      return Error{ErrorCode::kInvalidArgument,
                   "two robots or lidars have the topic " + scan +
                       "; give each robot a namespace of its own: --robot NAME=NAMESPACE",
                   ""};
    }
  }
  return std::nullopt;
}

/// One line at a time.
Log one_at_a_time(const Log& log) {
  return [log, mutex = std::make_shared<std::mutex>()](const std::string& line) {
    const std::lock_guard lock(*mutex);
    log(line);
  };
}

}  // namespace

struct Bridge::Parts {
  BridgeOptions options;
  std::vector<std::unique_ptr<RobotBridge>> robots;
  std::optional<DdsNode> node;  ///< Calls the robots until it is destroyed, so it comes last.
};

Bridge::Bridge(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Bridge::~Bridge() {
  // All at once, since each waits for its own request.
  for (const auto& robot : parts_->robots) robot->begin_stop();
  for (const auto& robot : parts_->robots) robot->stop();
}

Result<std::unique_ptr<Bridge>> Bridge::start(BridgeOptions options, const Log& log) {
  if (const auto shared = find_shared(options)) return *shared;
  auto parts = std::make_unique<Parts>();
  parts->options = std::move(options);
  const Log line_log = one_at_a_time(log);
  for (const RobotName& robot : parts->options.robots) {
    parts->robots.push_back(std::make_unique<RobotBridge>(parts->options, robot, line_log));
  }
  if (const auto wrong = parts->robots.front()->check()) return *wrong;
  Result<DdsNode> node = DdsNode::join(parts->options.domain, parts->options.is_local_only);
  if (!node) return node.error();
  parts->node = std::move(*node);
  std::unique_ptr<Bridge> bridge(new Bridge(std::move(parts)));
  for (const auto& robot : bridge->parts_->robots) {
    if (const auto started = robot->start(*bridge->parts_->node); !started) return started.error();
  }
  return bridge;
}

}  // namespace cornerfix::ros2
