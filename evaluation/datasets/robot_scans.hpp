/// \file  The scans of a log as a robot posts them, batch by batch, from where it is switched on.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "evaluation/datasets/log_position.hpp"
#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

struct RobotScanOptions {
  LogSelection selection;
  LogPosition from;    ///< Where the robot is switched on, behind the share left out.
  double split = 0.0;  ///< First share of the posed scans to leave out, since it made the map.
};

/// Holds one batch of the log. One thread at a time.
class RobotScans {
 public:
  /// An error as well when no scan is left. `progress` as in survey_log(); the log is surveyed if a
  /// share of it is left out.
  [[nodiscard]] static Result<RobotScans> open(const std::filesystem::path& path,
                                               const RobotScanOptions& options,
                                               const std::function<void(double)>& progress = {});

  /// The next `size` scans, fewer at the end of the log or of a run.
  [[nodiscard]] std::vector<LogScan> next_batch(std::size_t size);

  [[nodiscard]] const LogReader& log() const { return reader_; }

 private:
  explicit RobotScans(LogReader reader) : reader_(std::move(reader)) {}
  [[nodiscard]] bool go_to(std::size_t left_out, const LogPosition& from);

  LogReader reader_;
  std::optional<LogScan> ahead_;  ///< Read, but not given out.
};

/// Path length over the scans of a log, by the reference poses or else by odometry.
class DistanceTraveled {
 public:
  void add(const LogScan& scan);
  [[nodiscard]] double m() const { return distance_traveled_m_; }

 private:
  std::optional<LogScan> last_;  ///< Its poses.
  double distance_traveled_m_ = 0.0;
};

/// Seconds of log time since the first scan, without the pauses between runs.
class LogClock {
 public:
  /// `batch` is not empty.
  void add(std::span<const LogScan> batch);
  [[nodiscard]] double seconds() const { return seconds_; }

 private:
  std::optional<double> last_;  ///< Stamp.
  double seconds_ = 0.0;
};

}  // namespace cornerfix::evaluation
