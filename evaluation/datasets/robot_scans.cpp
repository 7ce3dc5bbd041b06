#include "evaluation/datasets/robot_scans.hpp"

#include "evaluation/datasets/log_survey.hpp"

namespace cornerfix::evaluation {

namespace {

double distance_between(const LogScan& from, const LogScan& to) {
  if (from.T_map_laser && to.T_map_laser) return distance(*from.T_map_laser, *to.T_map_laser);
  if (from.T_odom_laser && to.T_odom_laser) return distance(*from.T_odom_laser, *to.T_odom_laser);
  return 0.0;
}

}  // namespace

Result<RobotScans> RobotScans::open(const std::filesystem::path& path,
                                    const RobotScanOptions& options,
                                    const std::function<void(double)>& progress) {
  std::size_t left_out = 0;
  if (options.split > 0.0) {
    const Result<LogSurvey> survey = survey_log(path, options.selection, 1, progress);
    if (!survey) return survey.error();
    left_out = survey->posed_scans_in(options.split);
  }
  Result<LogReader> reader = LogReader::open(path, options.selection);
  if (!reader) return reader.error();
  RobotScans scans(std::move(*reader));
  if (scans.go_to(left_out, options.from)) return scans;
  return Error{ErrorCode::kInvalidArgument, "holds no scan from there on", path.string()};
}

std::vector<LogScan> RobotScans::next_batch(std::size_t size) {
  std::vector<LogScan> batch;
  while (batch.size() < size) {
    std::optional<LogScan> scan = ahead_ ? std::exchange(ahead_, std::nullopt) : reader_.next();
    if (!scan) break;
    if (scan->begins_run && !batch.empty()) {
      ahead_ = std::move(scan);
      break;
    }
    batch.push_back(std::move(*scan));
  }
  return batch;
}

/// False when the log ends before.
bool RobotScans::go_to(std::size_t left_out, const LogPosition& from) {
  std::size_t index = 0;
  std::optional<double> first_stamp;
  while (std::optional<LogScan> scan = reader_.next()) {
    if (left_out > 0) {
      left_out -= scan->T_map_laser ? 1 : 0;
      continue;
    }
    if (!first_stamp) first_stamp = scan->scan.stamp;
    if (is_reached(from, index++, scan->scan.stamp - *first_stamp)) {
      ahead_ = std::move(scan);
      return true;
    }
  }
  return false;
}

void DistanceTraveled::add(const LogScan& scan) {
  if (last_ && !scan.begins_run) distance_traveled_m_ += distance_between(*last_, scan);
  last_ = {{}, scan.T_odom_laser, scan.T_map_laser};
}

void LogClock::add(std::span<const LogScan> batch) {
  const double begin = batch.front().scan.stamp;
  if (last_ && !batch.front().begins_run) seconds_ += begin - *last_;
  last_ = batch.back().scan.stamp;
  seconds_ += *last_ - begin;
}

}  // namespace cornerfix::evaluation
