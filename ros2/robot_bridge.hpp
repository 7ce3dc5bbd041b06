/// \file  One robot: its topics on one side, its session on the other.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <cornerfix/result.hpp>

#include "ros2/bridge_options.hpp"
#include "ros2/dds_node.hpp"
#include "ros2/pose_gate.hpp"
#include "ros2/pose_publisher.hpp"
#include "ros2/scan_assembler.hpp"
#include "ros2/session_client.hpp"

namespace cornerfix::ros2 {

/// Posts scans and publishes answers in a thread of its own.
class RobotBridge {
 public:
  /// `options` must outlive it.
  RobotBridge(const BridgeOptions& options, RobotName robot, Log log);
  ~RobotBridge();
  RobotBridge(const RobotBridge&) = delete;
  RobotBridge& operator=(const RobotBridge&) = delete;

  /// What is wrong with the maps or the token; see SessionClient.
  [[nodiscard]] std::optional<Error> check() { return session_.check(); }

  /// Joins the topics and begins to post. `node` is to be destroyed before this.
  [[nodiscard]] Result<void> start(DdsNode& node);

  /// Breaks off what the thread does.
  void begin_stop();
  /// Ends the thread, which deletes the session. Messages are still taken.
  void stop();

 private:
  [[nodiscard]] Result<void> subscribe(DdsNode& node);
  [[nodiscard]] std::string topic(const std::string& name) const;
  [[nodiscard]] Result<void> subscribe_scans(DdsNode& node);
  /// Changes what messages are joined to, and wakes the thread.
  void update(const std::function<void(ScanAssembler&)>& change);

  void work();
  /// Empty when none became ready for a second, or at the end.
  [[nodiscard]] std::vector<AssembledScan> wait_for_batch();
  void post(const std::vector<AssembledScan>& batch);
  void publish(const Answer& answer, const AssembledScan& last_scan);
  void report_answer(const Answer& answer, const AssembledScan& last_scan);
  void report_idle();
  /// Publishes the diagnosis. When its message is a new one, it goes to the log with `detail`.
  void report(const Diagnosis& diagnosis, const std::string& detail = "");
  [[nodiscard]] bool is_stopping();
  /// False when it was ended by stop().
  bool pause(std::chrono::milliseconds duration);

  const BridgeOptions& options_;
  RobotName robot_;
  std::vector<std::string> scan_topics_;  ///< Full names.
  Log log_;
  SessionClient session_;
  PosePublisher publisher_;
  PoseGate gate_;
  std::string logged_;
  std::string logged_problem_;

  std::mutex mutex_;  ///< Of what follows.
  std::condition_variable changed_;
  ScanAssembler scans_;
  bool is_stopping_ = false;

  std::thread thread_;
};

}  // namespace cornerfix::ros2
