/// \file  What a log's file format must be able to do: give out its scans one after the other.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/datasets/log_fault.hpp"
#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

class LogSource {
 public:
  virtual ~LogSource() = default;

  /// The next scan, or nothing at the end of the log. What is broken is added to `faults` and left
  /// out; the end of what can be read is the end of the log.
  [[nodiscard]] virtual std::optional<LogScan> next(LogFaults& faults) = 0;
  /// Share of the file read so far, in [0, 1].
  [[nodiscard]] virtual double progress() const = 0;

  /// Complete once the first scan was given out.
  [[nodiscard]] const LogHeader& header() const { return header_; }
  /// What was assumed or left out, for people.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 protected:
  LogHeader header_;
  std::vector<std::string> notes_;
};

/// JSON lines or CARMEN, plain or gzip'd; a bag of ROS. `lidar` as in LogSelection.
[[nodiscard]] Result<std::unique_ptr<LogSource>> open_json_lines_log(
    const std::filesystem::path& path, const std::string& lidar);
[[nodiscard]] Result<std::unique_ptr<LogSource>> open_carmen_log(const std::filesystem::path& path,
                                                                 const std::string& lidar);
[[nodiscard]] Result<std::unique_ptr<LogSource>> open_bag(const std::filesystem::path& path,
                                                          const LogSelection& selection);

}  // namespace cornerfix::evaluation
