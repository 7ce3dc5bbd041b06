/// \file  Recorded runs as one stream of scans, from any kind of file.
///
/// JSON lines (.jsonl): first an object with `name`, `beams` and the lidar's
/// `angle_min`, `angle_increment`, `range_min`, `range_max`. Then a line per scan,
/// `{"t": s, "ranges": [m | null], "odom": [x, y, yaw] | null, "pose": [x, y, yaw] | null}`, with
/// "kf": 1 on key scans and "lidar" where there are several; other members are ignored.
/// CARMEN (.log, .clf, .gfs): FLASER, RLASER, ROBOTLASER1 and RAWLASER1 with ODOM and PARAM. A
/// FLASER that says no more of its pose than its odometry does has no reference pose.
/// Bags of ROS (.bag of format 2.0, .mcap, .db3, also .zstd; a directory of those):
/// sensor_msgs/LaserScan, MultiEchoLaserScan or PointCloud2 with nav_msgs/Odometry and tf. Where tf
/// knows `map`, the laser's pose there is the reference pose.
/// All poses are of the laser.
#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/result.hpp>

#include "evaluation/datasets/log_fault.hpp"

namespace cornerfix::evaluation {

/// What is known of a log as a whole.
struct LogHeader {
  std::string name;
  LaserScan lidar;        ///< Geometry of the first scan; its ranges are empty. Others may differ.
  std::size_t beams = 0;  ///< Of the first scan.
  std::string source;     ///< Where the log comes from, for people; may be empty.
};

/// Takes the geometry of `scan` for that of the log.
void set_lidar(LogHeader& header, const LaserScan& scan);
/// Whether a scan has exactly the geometry of the log's header.
[[nodiscard]] bool has_lidar_of(const LogHeader& header, const LaserScan& scan);

/// One line of a log.
struct LogScan {
  LaserScan scan;
  std::optional<Pose2> T_odom_laser;
  std::optional<Pose2> T_map_laser;  ///< The reference pose.
  bool is_key_scan = false;  ///< Some logs mark the scans whose reference pose is not interpolated.
  /// From beam to beam [s]; 0 for a scan that was taken at once. See ScanMotion.
  double time_increment = 0.0;
  /// angle_max as the log states it [rad]; angle_increment decides.
  std::optional<double> stated_angle_max = {};
  bool begins_run = false;  ///< The clock was set: the robot may stand anywhere.
};

/// A whole log in memory.
struct RecordedLog {
  LogHeader header;
  std::vector<LogScan> scans;
};

/// Heights above the sensor [m].
struct HeightBand {
  double min_m = -0.15;
  double max_m = 0.15;
};

/// What to take from a log that holds several.
struct LogSelection {
  /// A bag's topic, a CARMEN message ("RLASER") or a name of the member `lidar` of JSON lines.
  /// Empty for the topic of the most beams, or else the lidar of the first scan.
  std::string lidar = {};
  /// A bag's topic of nav_msgs/Odometry, which is then preferred to tf; empty for none in
  /// particular. An error for other logs, which have one odometry.
  std::string odometry = {};
  /// Where a point cloud is cut.
  HeightBand height = {};
  /// That the lidar takes for a scan [s]; 0: as the log says.
  double scan_time = 0.0;
};

class ConstantRange;
class LogSource;
class OddScans;
class ScanQueue;
class ScanStraightener;
class StampOrder;

/// Reads a log scan by scan, and holds no more of it than it needs for the next one. Stamps
/// strictly increase: see stamp_order.hpp. Ranges that stand for no return are recognized: see
/// constant_range.hpp. Scans that were taken beam by beam are straightened: see
/// scan_straightener.hpp. Records that are broken, and scans out of order, are left out and
/// counted. One thread at a time.
class LogReader {
 public:
  /// More beams than this has no lidar.
  static constexpr std::size_t kMaxBeams = 20000;

  /// Reads up to the first scan, so that the header is known.
  [[nodiscard]] static Result<LogReader> open(const std::filesystem::path& path,
                                              const LogSelection& selection = {});
  ~LogReader();
  LogReader(LogReader&&) noexcept;

  [[nodiscard]] const LogHeader& header() const;
  /// The next scan, or nothing at the end of the log.
  [[nodiscard]] std::optional<LogScan> next();
  /// Share of the file read so far, in [0, 1].
  [[nodiscard]] double progress() const;
  /// What was left out so far.
  [[nodiscard]] const LogFaults& faults() const { return faults_; }
  /// What was assumed, for people.
  [[nodiscard]] std::vector<std::string> notes() const;
  /// That more scans were left out than given out so far, with what is known about why; nothing
  /// when there were not.
  [[nodiscard]] std::optional<Error> most_scans_lost() const;

 private:
  LogReader(std::unique_ptr<LogSource> source, std::filesystem::path path, double scan_time);
  [[nodiscard]] std::optional<LogScan> next_recorded();
  [[nodiscard]] std::optional<LogScan> next_in_order();

  std::unique_ptr<LogSource> source_;
  std::filesystem::path path_;
  LogHeader header_;
  LogFaults faults_;
  std::unique_ptr<ConstantRange> constant_range_;
  std::deque<LogScan> recorded_;  ///< Read, for `constant_range_` to look at.
  std::unique_ptr<OddScans> oddities_;
  std::unique_ptr<ScanQueue> queue_;
  std::unique_ptr<StampOrder> order_;
  std::unique_ptr<ScanStraightener> straightener_;
  double scan_time_;
  bool is_read_ = false;          ///< The source, to its end.
  std::size_t scans_ = 0;         ///< Given out, and `ahead_`.
  std::optional<LogScan> ahead_;  ///< Read, but not given out.
};

/// What a person should know about a log that was read: notes, and the broken records. May be
/// empty.
[[nodiscard]] std::string remarks(const LogReader& reader);

/// All of a log; `stride` n keeps every n-th scan, from the first.
[[nodiscard]] Result<RecordedLog> read_log(const std::filesystem::path& path,
                                           std::size_t stride = 1);
/// The rest of a log. \param progress  Called with the share of the file read, a scan each; may be
/// empty.
[[nodiscard]] RecordedLog read_all(LogReader& reader, std::size_t stride = 1,
                                   const std::function<void(double)>& progress = {});

}  // namespace cornerfix::evaluation
