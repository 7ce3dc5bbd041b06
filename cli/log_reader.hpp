/// \file  Recorded drives as one stream of scans, whatever file they are in.
///
/// JSON lines (.jsonl, .jsonl.gz): first an object with `name`, `beams` and the lidar's
/// `angle_min`, `angle_increment`, `range_min`, `range_max`; then a line a scan,
/// {"t": s, "ranges": [m | null], "odom": [x, y, yaw] | null, "pose": [x, y, yaw] | null}, with
/// "kf": 1 on key scans; other members are ignored.
/// CARMEN (.log, .clf, .gfs): the FLASER messages. All poses are of the laser.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix::cli {

/// What all scans of a log share.
struct LogHeader {
  std::string name;
  LaserScan lidar;        ///< Geometry; its ranges are empty.
  std::size_t beams = 0;  ///< Of every scan.
  std::string source;     ///< Where the log comes from, for people; may be empty.
};

/// One line of a log.
struct LogScan {
  LaserScan scan;
  std::optional<Pose2> T_odom_laser;
  std::optional<Pose2> T_map_laser;  ///< The reference pose.
  bool is_key_scan = false;  ///< Some logs mark the scans whose reference pose is not interpolated.
};

/// A whole log in memory.
struct RecordedLog {
  LogHeader header;
  std::vector<LogScan> scans;
};

class ScanParser;
class LineReader;

/// Reads a log scan by scan. One thread at a time.
class LogReader {
 public:
  /// Reads up to the first scan, so that the header is known. Errors name file and line.
  [[nodiscard]] static Result<LogReader> open(const std::filesystem::path& path);
  ~LogReader();
  LogReader(LogReader&&) noexcept;

  [[nodiscard]] const LogHeader& header() const;
  /// The next scan, or nothing at the end of the log.
  [[nodiscard]] Result<std::optional<LogScan>> next();
  /// Share of the file read so far, in [0, 1].
  [[nodiscard]] double progress() const;

 private:
  LogReader(std::unique_ptr<LineReader> lines, std::unique_ptr<ScanParser> parser,
            std::filesystem::path path);
  [[nodiscard]] Result<std::optional<LogScan>> parse_next();

  std::filesystem::path path_;
  std::unique_ptr<LineReader> lines_;
  std::unique_ptr<ScanParser> parser_;
  std::optional<LogScan> first_;  ///< Read ahead by open().
};

/// All of a log; `stride` n keeps every n-th scan, from the first.
[[nodiscard]] Result<RecordedLog> read_log(const std::filesystem::path& path,
                                           std::size_t stride = 1);

}  // namespace cornerfix::cli
