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
#include "cli/server_connection.hpp"
#include "clients/cpp/scan_json.hpp"
#include "evaluation/datasets/log_position.hpp"
#include "evaluation/datasets/log_survey.hpp"
#include "evaluation/metrics/degrees.hpp"

namespace cornerfix::cli {

namespace {

struct ReplayArguments {
  ConnectionOptions connection;
  std::string log;
  evaluation::LogSelection selection;
  std::string map;
  std::string robot = "replay";
  evaluation::LogPosition from;
  double split = 0.0;
  std::size_t batch = 5;
  double rate = 0.0;
  double track_m = 5.0;
  bool no_odometry = false;
  bool keep_session = false;
};

/// The way from one scan to the next, by the reference poses or else by odometry [m].
double way_between(const evaluation::LogScan& from, const evaluation::LogScan& to) {
  if (from.T_map_laser && to.T_map_laser) return distance(*from.T_map_laser, *to.T_map_laser);
  if (from.T_odom_laser && to.T_odom_laser) return distance(*from.T_odom_laser, *to.T_odom_laser);
  return 0.0;
}

Result<evaluation::LogSurvey> survey_with_progress(const ReplayArguments& arguments) {
  Progress progress("reading");
  return evaluation::survey_log(arguments.log, arguments.selection, 1,
                                [&](double share) { progress.update(share); });
}

/// The scans that a robot posts: those behind the share that made the map, from where it is
/// switched on.
class RobotScans {
 public:
  [[nodiscard]] static Result<RobotScans> open(const ReplayArguments& arguments) {
    std::size_t left_out = 0;
    if (arguments.split > 0.0) {
      const Result<evaluation::LogSurvey> survey = survey_with_progress(arguments);
      if (!survey) return survey.error();
      left_out = survey->posed_scans_in(arguments.split);
    }
    Result<evaluation::LogReader> reader =
        evaluation::LogReader::open(arguments.log, arguments.selection);
    if (!reader) return reader.error();
    RobotScans scans(std::move(*reader));
    if (scans.go_to(left_out, arguments.from)) return scans;
    return Error{ErrorCode::kInvalidArgument, "holds no scan from there on", arguments.log};
  }

  /// The next `size` scans, fewer at the end of the log or of a run.
  std::vector<evaluation::LogScan> next_batch(std::size_t size) {
    std::vector<evaluation::LogScan> batch;
    while (batch.size() < size) {
      std::optional<evaluation::LogScan> scan =
          ahead_ ? std::exchange(ahead_, std::nullopt) : reader_.next();
      if (!scan) break;
      if (scan->begins_run && !batch.empty()) {
        ahead_ = std::move(scan);
        break;
      }
      batch.push_back(std::move(*scan));
    }
    return batch;
  }

  [[nodiscard]] const evaluation::LogReader& log() const { return reader_; }

 private:
  explicit RobotScans(evaluation::LogReader reader) : reader_(std::move(reader)) {}

  /// False when the log ends before.
  bool go_to(std::size_t left_out, const evaluation::LogPosition& from) {
    std::size_t index = 0;
    std::optional<double> first_stamp;
    while (std::optional<evaluation::LogScan> scan = reader_.next()) {
      if (left_out > 0) {
        left_out -= scan->T_map_laser ? 1 : 0;
        continue;
      }
      if (!first_stamp) first_stamp = scan->scan.stamp;
      if (evaluation::is_reached(from, index++, scan->scan.stamp - *first_stamp)) {
        ahead_ = std::move(scan);
        return true;
      }
    }
    return false;
  }

  evaluation::LogReader reader_;
  std::optional<evaluation::LogScan> ahead_;  ///< Read, but not given out.
};

/// Metres driven so far.
class Way {
 public:
  void add(const evaluation::LogScan& scan) {
    if (last_ && !scan.begins_run) way_m_ += way_between(*last_, scan);
    last_ = {{}, scan.T_odom_laser, scan.T_map_laser};
  }
  [[nodiscard]] double m() const { return way_m_; }

 private:
  std::optional<evaluation::LogScan> last_;  ///< Its poses.
  double way_m_ = 0.0;
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
  const std::size_t places = answer.value("hypotheses", nlohmann::json::array()).size();
  if (answer.value("status", "") == "ambiguous" && places > 0) {
    if (!text.empty()) text += ", ";
    text += std::to_string(places) + " places";
  }
  return text;
}

/// Seconds, metres, status, then the pose beside the true one, or why there is none.
void print_answer(const nlohmann::json& answer, double seconds, double way,
                  const evaluation::LogScan& last) {
  std::printf("%8.1f s %7.2f m  %-10s", seconds, way, answer.value("status", "?").c_str());
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

/// One robot: a session that posts a log's scans batch by batch.
class Robot {
 public:
  Robot(const ReplayArguments& arguments, const evaluation::LogHeader& header,
        ServerConnection& server)
      : arguments_(arguments), header_(header), server_(server) {}

  Result<void> switch_on() {
    nlohmann::ordered_json body = {{"robot", arguments_.robot}, {"map", nullptr}};
    if (!arguments_.map.empty()) body["map"] = arguments_.map;
    body["lidar"] = client::lidar_json(header_);
    const auto answer =
        server_.call({"POST", "/v1/sessions", body.dump(), /*creates_session=*/true});
    if (!answer) return answer.error();
    session_ = server_.is_printing() ? std::string(client::kSessionVariable)
                                     : client::percent_encode(answer->value("id", ""));
    return {};
  }

  Result<nlohmann::json> post(std::span<const evaluation::LogScan> batch) {
    auto scans = nlohmann::ordered_json::array();
    for (const evaluation::LogScan& scan : batch) {
      scans.push_back(client::robot_scan_json(header_, scan, !arguments_.no_odometry));
    }
    const nlohmann::ordered_json body = {{"sequence", sequence_++}, {"scans", std::move(scans)}};
    return server_.call({"POST", "/v1/sessions/" + session_ + "/scans", body.dump()});
  }

  /// Forgets the pose: the robot may have been carried since.
  Result<void> reset() {
    const auto answer = server_.call({"POST", "/v1/sessions/" + session_ + "/reset"});
    if (!answer) return answer.error();
    return {};
  }

  Result<void> switch_off() {
    const auto answer = server_.call({"DELETE", "/v1/sessions/" + session_});
    if (!answer) return answer.error();
    return {};
  }

 private:
  const ReplayArguments& arguments_;
  const evaluation::LogHeader& header_;
  ServerConnection& server_;
  std::string session_;
  std::size_t sequence_ = 0;
};

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

/// Seconds of log time since the first scan, without the pauses between runs.
class LogClock {
 public:
  void add(std::span<const evaluation::LogScan> batch) {
    const double begin = batch.front().scan.stamp;
    if (last_ && !batch.front().begins_run) seconds_ += begin - *last_;
    last_ = batch.back().scan.stamp;
    seconds_ += *last_ - begin;
  }
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  std::optional<double> last_;  ///< Stamp.
  double seconds_ = 0.0;
};

/// Prints an answer when its status is not that of the one before, and the last one in any case.
// The move constructor that nlohmann::json declares noexcept checks an invariant that holds.
class ChangePrinter {  // NOLINT(bugprone-exception-escape)
 public:
  void add(nlohmann::json answer, double seconds, double way,
           const evaluation::LogScan& last_scan) {
    const bool is_change = status(answer) != status(answer_);
    answer_ = std::move(answer);
    seconds_ = seconds;
    way_ = way;
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
    print_answer(answer_, seconds_, way_, *last_scan_);
    is_printed_ = true;
  }

  nlohmann::json answer_;
  double seconds_ = 0.0;
  double way_ = 0.0;
  std::optional<evaluation::LogScan> last_scan_;
  bool is_printed_ = false;
};

/// True when the robot is localized at the end: of the log, or some way after it was localized.
Result<bool> drive(Robot& robot, const ReplayArguments& arguments, RobotScans& scans,
                   bool is_printing_curl) {
  const Pace pace(is_printing_curl ? 0.0 : arguments.rate);
  ChangePrinter printer;
  std::optional<double> fixed_at_m;
  LogClock clock;
  Way way;
  for (auto batch = scans.next_batch(arguments.batch); !batch.empty();
       batch = scans.next_batch(arguments.batch)) {
    clock.add(batch);
    for (const evaluation::LogScan& scan : batch) way.add(scan);
    pace.wait_until(clock.seconds());
    if (batch.front().begins_run) {
      if (const auto reset = robot.reset(); !reset) return reset.error();
    }
    Result<nlohmann::json> answer = robot.post(batch);
    if (!answer) return answer.error();
    if (is_printing_curl) continue;
    printer.add(std::move(*answer), clock.seconds(), way.m(), batch.back());
    if (!fixed_at_m && printer.is_localized()) fixed_at_m = way.m();
    if (fixed_at_m && way.m() >= *fixed_at_m + arguments.track_m) break;
  }
  printer.finish();
  return printer.is_localized();
}

int run_replay(const ReplayArguments& arguments) {
  Result<RobotScans> scans = RobotScans::open(arguments);
  if (!scans) return fail(scans.error());
  Result<ServerConnection> server = ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  Robot robot(arguments, scans->log().header(), *server);
  const Result<void> on = robot.switch_on();
  if (!on) return fail(on.error());
  const Result<bool> localized = drive(robot, arguments, *scans, server->is_printing());
  const std::optional<Error> lost = scans->log().most_scans_lost();
  if (!lost) warn(arguments.log, evaluation::remarks(scans->log()));
  if (!arguments.keep_session) {
    const Result<void> off = robot.switch_off();
    if (localized && !off) return fail(off.error());
  }
  if (!localized) return fail(localized.error());
  if (lost) return fail(*lost);
  return *localized || server->is_printing() ? kDone : kCouldNot;
}

void add_options(CLI::App& command, ReplayArguments& arguments) {
  add_log(command, arguments.log);
  add_selection(command, arguments.selection);
  command.add_option("--map", arguments.map, "Map to look in (default: all that the server has)")
      ->check(map_name());
  command.add_option("--robot", arguments.robot, "Name of the robot")->capture_default_str();
  command
      .add_option("--split", arguments.split,
                  "Leave out this first share of the log: it made the map")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--from",
          [&arguments](const std::string& text) {
            const auto from = evaluation::parse_log_position(text);
            if (!from) throw CLI::ValidationError("--from", "expected a number, or one with s");
            arguments.from = *from;
          },
          "Switch the robot on at this scan (120), or after this time (30s)")
      ->type_name("N|Ns");
  command.add_option("--batch", arguments.batch, "Scans a request, 1 to 100")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command.add_option("--rate", arguments.rate, "Times the speed of the log; 0 as fast as it goes")
      ->check(not_below_zero())
      ->capture_default_str();
  command.add_option("--track", arguments.track_m, "Metres to drive on after the first fix")
      ->check(not_below_zero())
      ->capture_default_str();
  command.add_flag("--no-odom", arguments.no_odometry, "Post no odometry");
  command.add_flag("--keep-session", arguments.keep_session,
                   "Leave the session on the server, for the inspector to show");
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* command = app.add_subcommand(
      "replay", "Be a robot: post a log's scans and print each change of what the server answers");
  command->footer(
      "Prints log time, way, status, and the pose beside the true one where the log has it.\n"
      "Ends some way after the first fix or with the log; exit code 0 when localized then, else "
      "1.");
  add_options(*command, *arguments);
  add_connection_options(*command, arguments->connection);
  command->callback([arguments, &exit_code] { exit_code = run_replay(*arguments); });
}

}  // namespace cornerfix::cli
