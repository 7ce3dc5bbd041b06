#include "ros2/robot_bridge.hpp"

#include <cstdio>
#include <numbers>
#include <utility>

#include "ros2/message_values.hpp"

namespace cornerfix::ros2 {

namespace {

constexpr auto kReportPeriod = std::chrono::seconds(1);

std::string pose_text(const LocalizedPose& pose) {
  const Pose2& T = pose.T_map_base_link;
  char text[96];
  std::snprintf(text, sizeof text, ": x %.2f m, y %.2f m, yaw %.1f deg", T.x, T.y,
                T.yaw * 180.0 / std::numbers::pi);
  return " in " + pose.map + text;
}

std::string status_text(const Answer& answer) {
  return answer.reason.empty() ? answer.status : answer.status + " (" + answer.reason + ")";
}

/// \param stamp  Of the last scan that was answered [s].
Diagnosis diagnose(const Answer& answer, double stamp) {
  Diagnosis diagnosis;
  diagnosis.level = answer.pose ? Diagnosis::Level::kOk : Diagnosis::Level::kWarn;
  diagnosis.message = status_text(answer);
  diagnosis.values = {{"status", answer.status},
                      {"reason", answer.reason},
                      {"epoch", answer.pose ? std::to_string(answer.pose->epoch) : ""},
                      {"confidence", std::to_string(answer.confidence)},
                      {"map", answer.pose ? answer.pose->map : ""},
                      {"confirmed", answer.pose && answer.pose->is_confirmed ? "true" : "false"},
                      {"session", answer.session},
                      {"stamp", std::to_string(stamp)}};
  return diagnosis;
}

std::vector<std::string> full_names(const std::vector<std::string>& topics,
                                    const BridgeOptions& options, const std::string& ns) {
  std::vector<std::string> names;
  names.reserve(topics.size());
  for (const std::string& topic : topics) names.push_back(options.remappings.resolve(topic, ns));
  return names;
}

/// Names of the lidars on the server; empty for one lidar, which needs none.
std::vector<std::string> names_of_several(const std::vector<std::string>& topics) {
  std::vector<std::string> names;
  if (topics.size() < 2) return names;
  for (const std::string& topic : topics) names.push_back(lidar_name(topic));
  return names;
}

ScanAssembler::Options assembler_options(const BridgeOptions& options,
                                         const std::vector<std::string>& topics) {
  ScanAssembler::Options out{.base_frame = options.base_frame, .max_rate_hz = options.max_rate_hz};
  if (topics.size() > 1) out.lidars = names_of_several(topics);
  return out;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

RobotBridge::RobotBridge(const BridgeOptions& options, RobotName robot, Log log)
    : options_(options),
      robot_(std::move(robot)),
      scan_topics_(full_names(options.scan_topics, options, robot_.ns)),
      log_(std::move(log)),
      session_(options.server,
               {robot_.name, options.maps, names_of_several(scan_topics_), options.near}),
      gate_(options.when),
      scans_(assembler_options(options, scan_topics_)) {}

RobotBridge::~RobotBridge() { stop(); }

std::string RobotBridge::topic(const std::string& name) const {
  return options_.remappings.resolve(name, robot_.ns);
}

Result<void> RobotBridge::start(DdsNode& node) {
  const PoseTopics topics{topic("initialpose"), options_.publishes_tf ? topic("tf") : "",
                          topic("diagnostics")};
  if (auto opened = publisher_.open(node, topics); !opened) return opened;
  if (auto subscribed = subscribe(node); !subscribed) return subscribed;
  thread_ = std::thread([this] { work(); });
  return {};
}

Result<void> RobotBridge::subscribe(DdsNode& node) {
  const auto add_transforms = [this](const TfMessage& message, FrameTree::Origin origin) {
    update([&](ScanAssembler& scans) {
      for (const auto& transform : transforms(message)) scans.add_transform(transform, origin);
    });
  };
  auto done = node.subscribe<TfMessage>(
      dds_topic(topic("tf_static")), kTfStatic,
      [=](const TfMessage& message) { add_transforms(message, FrameTree::Origin::kStatic); });
  if (!done) return done;
  done = node.subscribe<TfMessage>(dds_topic(topic("tf")), kTf, [=](const TfMessage& message) {
    add_transforms(message, FrameTree::Origin::kTf);
  });
  if (!done) return done;
  done = node.subscribe<OdometryMessage>(
      dds_topic(topic("odom")), kOdometry, [this](const OdometryMessage& message) {
        const auto transform = odometry_transform(message);
        update([&](ScanAssembler& scans) { scans.add_odometry(transform); });
      });
  if (!done) return done;
  return subscribe_scans(node);
}

Result<void> RobotBridge::subscribe_scans(DdsNode& node) {
  for (std::size_t lidar = 0; lidar < scan_topics_.size(); ++lidar) {
    auto done = node.subscribe<LaserScanMessage>(
        dds_topic(scan_topics_[lidar]), kSensorData,
        [this, lidar](const LaserScanMessage& message) {
          update([&](ScanAssembler& scans) {
            scans.add_scan(received_scan(message), ScanAssembler::Clock::now(), lidar);
          });
        });
    if (!done) return done;
  }
  return {};
}

void RobotBridge::update(const std::function<void(ScanAssembler&)>& change) {
  {
    const std::lock_guard lock(mutex_);
    change(scans_);
  }
  changed_.notify_one();
}

void RobotBridge::begin_stop() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(is_stopping_, true)) return;
  }
  changed_.notify_one();
  session_.stop();
}

void RobotBridge::stop() {
  begin_stop();
  if (thread_.joinable()) thread_.join();
}

bool RobotBridge::is_stopping() {
  const std::lock_guard lock(mutex_);
  return is_stopping_;
}

bool RobotBridge::pause(std::chrono::milliseconds duration) {
  std::unique_lock lock(mutex_);
  return !changed_.wait_for(lock, duration, [this] { return is_stopping_; });
}

void RobotBridge::work() {
  log_(robot_.name + ": waiting for scans on " + joined(scan_topics_));
  while (!is_stopping()) {
    const std::vector<AssembledScan> batch = wait_for_batch();
    if (!batch.empty()) {
      post(batch);
    } else {
      report_idle();
    }
  }
  session_.close();
}

std::vector<AssembledScan> RobotBridge::wait_for_batch() {
  const auto end = ScanAssembler::Clock::now() + kReportPeriod;
  std::unique_lock lock(mutex_);
  while (!is_stopping_) {
    const auto now = ScanAssembler::Clock::now();
    std::vector<AssembledScan> batch = scans_.take_batch(now);
    if (!batch.empty() || now >= end) return batch;
    const auto deadline = scans_.next_deadline(now);
    changed_.wait_until(lock, deadline ? std::min(*deadline, end) : end);
  }
  return {};
}

void RobotBridge::post(const std::vector<AssembledScan>& batch) {
  while (!is_stopping()) {
    const SessionClient::Outcome outcome = session_.post(batch);
    if (outcome.answer) return publish(*outcome.answer, batch.back());
    if (is_stopping()) return;
    report({Diagnosis::Level::kError, outcome.problem, {}});
    if (outcome.kind == SessionClient::Outcome::Kind::kRefused || !pause(outcome.wait)) return;
  }
}

void RobotBridge::publish(const Answer& answer, const AssembledScan& last_scan) {
  if (gate_.pass(answer, publisher_.has_pose_subscriber())) {
    publisher_.publish_pose(*answer.pose, options_.map_frame);
    log_(robot_.name + ": pose of epoch " + std::to_string(answer.pose->epoch) + " published on " +
         topic("initialpose"));
  }
  if (gate_.is_open(answer) && last_scan.T_odom_base_link) {
    std::unique_lock lock(mutex_);
    const std::string odom_frame = scans_.odom_frame();
    lock.unlock();
    publisher_.publish_transform(*answer.pose, *last_scan.T_odom_base_link, options_.map_frame,
                                 odom_frame);
  }
  report_answer(answer, last_scan);
}

void RobotBridge::report_answer(const Answer& answer, const AssembledScan& last_scan) {
  std::unique_lock lock(mutex_);
  const std::string problem = scans_.problem();  // Of one of several lidars.
  lock.unlock();
  Diagnosis diagnosis = diagnose(answer, last_scan.scan.stamp);
  if (!problem.empty()) {
    diagnosis.level = Diagnosis::Level::kWarn;
    diagnosis.values.emplace_back("problem", problem);
  }
  if (std::exchange(logged_problem_, problem) != problem && !problem.empty())
    log_(robot_.name + ": " + problem);
  report(diagnosis, answer.pose ? pose_text(*answer.pose) : "");
}

void RobotBridge::report_idle() {
  std::unique_lock lock(mutex_);
  if (is_stopping_) return;
  std::string problem = scans_.problem();
  lock.unlock();
  if (problem.empty()) problem = "no scans on " + joined(scan_topics_);
  report({Diagnosis::Level::kError, problem, {}});
}

void RobotBridge::report(const Diagnosis& diagnosis, const std::string& detail) {
  publisher_.publish_diagnosis(diagnosis, robot_.name);
  if (diagnosis.message == logged_) return;
  logged_ = diagnosis.message;
  log_(robot_.name + ": " + diagnosis.message + detail);
}

}  // namespace cornerfix::ros2
