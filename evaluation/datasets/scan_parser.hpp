/// \file  What a log's file format must be able to do: turn its lines into scans.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

class ScanParser {
 public:
  virtual ~ScanParser() = default;

  /// The scan in a line, or nothing when the line holds none. `line` has room for simdjson's
  /// padding behind it. An error's message does not name the line, the caller knows it.
  [[nodiscard]] virtual Result<std::optional<LogScan>> parse(const std::string& line) = 0;

  /// A scan that waited for a line that did not come, once all lines were parsed.
  [[nodiscard]] virtual std::optional<LogScan> finish() { return std::nullopt; }

  /// What the lines hold that are no scans to be taken, for people; may be empty.
  [[nodiscard]] virtual std::string contents() const { return ""; }

  /// Which lidar's scans are taken and which are not, once that is known; for people.
  [[nodiscard]] virtual std::string choice() const { return ""; }

  /// What was assumed about the scans, for people; may be empty.
  [[nodiscard]] virtual std::string assumption() const { return ""; }

  /// Complete once the first scan was parsed.
  [[nodiscard]] const LogHeader& header() const { return header_; }

 protected:
  LogHeader header_;
};

/// `lidar` is the name of the scans to take, or empty for that of the first scan. It is a value of
/// the member `lidar` in JSON lines, or a message of CARMEN ("FLASER").
[[nodiscard]] std::unique_ptr<ScanParser> make_json_lines_parser(std::string lidar);
[[nodiscard]] std::unique_ptr<ScanParser> make_carmen_parser(std::string lidar);

}  // namespace cornerfix::evaluation
