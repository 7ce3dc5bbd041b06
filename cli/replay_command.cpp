#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cli/command.hpp"
#include "cli/progress.hpp"
#include "cli/server_options.hpp"
#include "clients/cpp/robot_session.hpp"
#include "clients/cpp/scan_json.hpp"
#include "evaluation/datasets/robot_scans.hpp"
#include "evaluation/metrics/degrees.hpp"

namespace cornerfix::cli {

namespace {

struct ReplayArguments {
  client::ConnectionOptions connection;
  std::string log;
  evaluation::RobotScanOptions scans;
  client::RobotSessionOptions session{.robot = "replay"};
  std::size_t batch = 5;
  double rate = 0.0;
  double track_m = 5.0;
  bool keep_session = false;
};

std::string pose_text(const Pose2& pose) {
  char text[96];
  std::snprintf(text, sizeof text, "x %.2f m, y %.2f m, yaw %.1f deg", pose.x, pose.y,
                pose.yaw * evaluation::kDegreesPerRadian);
  return text;
}

std::string error_text(const Pose2& pose, const Pose2& truth) {
  char text[96];
  std::snprintf(text, sizeof text, "error %.2f m, %.1f deg", distance(pose, truth),
                angle_between(pose, truth) * evaluation::kDegreesPerRadian);
  return text;
}

std::string reason_text(const nlohmann::json& answer) {
  const auto reason = answer.find("reason");
  std::string text =
      reason != answer.end() && reason->is_string() ? reason->get<std::string>() : "";
  const std::size_t poses = answer.value("hypotheses", nlohmann::json::array()).size();
  if (answer.value("status", "") == "ambiguous" && poses > 0) {
    if (!text.empty()) text += ", ";
    text += std::to_string(poses) + " poses";
  }
  return text;
}

/// Seconds, metres, status, then the pose beside the true one, or why there is none.
void print_answer(const nlohmann::json& answer, double seconds, double distance_m,
                  const evaluation::LogScan& last) {
  std::printf("%8.1f s %7.2f m  %-10s", seconds, distance_m, answer.value("status", "?").c_str());
  const auto pose_member = answer.find("pose");
  const auto pose =
      pose_member == answer.end() ? std::nullopt : client::pose_from_json(*pose_member);
  if (!pose) {
    std::printf("  %s\n", reason_text(answer).c_str());
  } else {
    std::printf("  %s: %s (confidence %.3f)\n", pose_member->value("map", "?").c_str(),
                pose_text(*pose).c_str(), answer.value("confidence", 0.0));
    if (last.T_map_laser) {
      std::printf("%33s%s; %s\n", "true: ", pose_text(*last.T_map_laser).c_str(),
                  error_text(*pose, *last.T_map_laser).c_str());
    }
  }
  std::fflush(stdout);
}

/// Lets log time pass at `rate` times its own speed.
class Pace {
 public:
  explicit Pace(double rate) : rate_(rate), start_(std::chrono::steady_clock::now()) {}

  void wait_until(double log_seconds) const {
    if (rate_ <= 0.0) return;
    std::this_thread::sleep_until(start_ + std::chrono::duration<double>(log_seconds / rate_));
  }

 private:
  double rate_;
  std::chrono::steady_clock::time_point start_;
};

/// Prints an answer when its status is not that of the one before, and the last one in any case.
// The move constructor that nlohmann::json declares noexcept checks an invariant that holds.
class ChangePrinter {  // NOLINT(bugprone-exception-escape)
 public:
  void add(nlohmann::json answer, double seconds, double distance_m,
           const evaluation::LogScan& last_scan) {
    const bool is_change = status(answer) != status(answer_);
    answer_ = std::move(answer);
    seconds_ = seconds;
    distance_m_ = distance_m;
    last_scan_ = last_scan;
    is_printed_ = false;
    if (is_change) print();
  }

  void finish() {
    if (last_scan_ && !is_printed_) print();
  }

  [[nodiscard]] bool is_localized() const { return status(answer_) == "localized"; }

 private:
  static std::string status(const nlohmann::json& answer) {
    return answer.is_object() ? answer.value("status", "") : "";
  }

  void print() {
    print_answer(answer_, seconds_, distance_m_, *last_scan_);
    is_printed_ = true;
  }

  nlohmann::json answer_;
  double seconds_ = 0.0;
  double distance_m_ = 0.0;
  std::optional<evaluation::LogScan> last_scan_;
  bool is_printed_ = false;
};

/// True when the robot is localized at the end: of the log, or of the metres after it was
/// localized.
Result<bool> post_scans(client::RobotSession& session, const ReplayArguments& arguments,
                        evaluation::RobotScans& scans, bool is_printing_curl) {
  const Pace pace(is_printing_curl ? 0.0 : arguments.rate);
  ChangePrinter printer;
  std::optional<double> localized_at_m;
  evaluation::LogClock clock;
  evaluation::DistanceTraveled distance;
  for (auto batch = scans.next_batch(arguments.batch); !batch.empty();
       batch = scans.next_batch(arguments.batch)) {
    clock.add(batch);
    for (const evaluation::LogScan& scan : batch) distance.add(scan);
    pace.wait_until(clock.seconds());
    if (batch.front().begins_run) {
      if (const auto reset = session.reset(); !reset) return reset.error();
    }
    Result<nlohmann::json> answer = session.post(batch);
    if (!answer) return answer.error();
    if (is_printing_curl) continue;
    printer.add(std::move(*answer), clock.seconds(), distance.m(), batch.back());
    if (!localized_at_m && printer.is_localized()) localized_at_m = distance.m();
    if (localized_at_m && distance.m() >= *localized_at_m + arguments.track_m) break;
  }
  printer.finish();
  return printer.is_localized();
}

Result<evaluation::RobotScans> open_scans(const ReplayArguments& arguments) {
  Progress progress("reading");
  return evaluation::RobotScans::open(arguments.log, arguments.scans,
                                      [&](double share) { progress.update(share); });
}

int run_replay(const ReplayArguments& arguments) {
  Result<evaluation::RobotScans> scans = open_scans(arguments);
  if (!scans) return fail(scans.error());
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  client::RobotSession session(arguments.session, scans->log().header(), *server);
  const Result<void> opened = session.open();
  if (!opened) return fail(opened.error());
  const Result<bool> localized = post_scans(session, arguments, *scans, server->is_printing());
  const std::optional<Error> lost = scans->log().most_scans_lost();
  if (!lost) warn(arguments.log, evaluation::remarks(scans->log()));
  if (!arguments.keep_session) {
    const Result<void> closed = session.close();
    if (localized && !closed) return fail(closed.error());
  }
  if (!localized) return fail(localized.error());
  if (lost) return fail(*lost);
  return *localized || server->is_printing() ? kDone : kCouldNot;
}

void add_options(CLI::App& command, ReplayArguments& arguments) {
  add_log(command, arguments.log);
  add_selection(command, arguments.scans.selection);
  command
      .add_option("--map", arguments.session.map,
                  "Map to look in (default: all that the server has)")
      ->check(map_name());
  command.add_option("--robot", arguments.session.robot, "Name of the robot")
      ->capture_default_str();
  command
      .add_option("--split", arguments.scans.split,
                  "Leave out this first share of the log: it made the map")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--from",
          [&arguments](const std::string& text) {
            const auto from = evaluation::parse_log_position(text);
            if (!from) throw CLI::ValidationError("--from", "expected a number, or one with s");
            arguments.scans.from = *from;
          },
          "Switch the robot on at this scan (120), or after this time (30s)")
      ->type_name("N|Ns");
  command.add_option("--batch", arguments.batch, "Scans a request, 1 to 100")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command.add_option("--rate", arguments.rate, "Times the speed of the log; 0 as fast as it goes")
      ->check(not_below_zero())
      ->capture_default_str();
  command
      .add_option("--track", arguments.track_m,
                  "Metres to drive on after the first localized answer")
      ->check(not_below_zero())
      ->capture_default_str();
  command.add_flag_callback(
      "--no-odom", [&arguments] { arguments.session.posts_odometry = false; }, "Post no odometry");
  command.add_flag("--keep-session", arguments.keep_session,
                   "Leave the session on the server, for the inspector to show");
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* command = app.add_subcommand(
      "replay", "Be a robot: post a log's scans and print each change of what the server answers");
  command->footer(
      "Prints log time, path length, status, and the pose beside the true one where the log has "
      "it.\n"
      "Ends --track metres after the first localized answer or with the log; exit code 0 when\n"
      "localized then, else 1.");
  add_options(*command, *arguments);
  add_connection_options(*command, arguments->connection);
  command->callback([arguments, &exit_code] { exit_code = run_replay(*arguments); });
}

}  // namespace cornerfix::cli
