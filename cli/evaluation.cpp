#include "cli/evaluation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <thread>

#include <cornerfix/grid_mapping.hpp>
#include <cornerfix/map_image.hpp>

#include "cli/log_split.hpp"

namespace cornerfix::cli {
namespace {

constexpr double kRightDistance = 0.5;  // [m]
constexpr double kRightAngle = 5.0 * std::numbers::pi / 180.0;
constexpr double kLooseAngle =
    15.0 * std::numbers::pi / 180.0;  // between key scans, whose headings are interpolated

double processor_ms(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Processor time of this thread: what a scan costs, whatever else the machine does.
double thread_ms() { return processor_ms(CLOCK_THREAD_CPUTIME_ID); }

bool has_key_scans(const RecordedLog& log) {
  return std::any_of(log.scans.begin(), log.scans.end(),
                     [](const LogScan& scan) { return scan.is_key_scan; });
}

struct Error2 {
  double m = 0.0;
  double rad = 0.0;
};

Error2 error_of(const Pose2& pose, const Pose2& truth) {
  return {distance(pose, truth), angle_between(pose, truth)};
}

/// Normalised estimation error squared: the error in units of what the answer says of its
/// certainty.
double nees_of(const LocalizedPose& pose, const Pose2& truth) {
  const Eigen::Map<const Eigen::Matrix3d> covariance(pose.covariance.data());
  const Pose2& at = pose.T_map_base_link;
  const Eigen::Vector3d error{at.x - truth.x, at.y - truth.y, wrap_angle(at.yaw - truth.yaw)};
  return error.dot(covariance.ldlt().solve(error));
}

/// One robot from its switch-on to its verdict.
class Drive {
 public:
  Drive(const RecordedLog& log, std::span<const std::size_t> order,
        const std::vector<LocalizationMapPtr>& maps, std::size_t right_map,
        const std::vector<Point2>& mapping_positions, const EvaluationOptions& options)
      : log_(log),
        order_(order),
        maps_(maps),
        right_map_(right_map),
        mapping_positions_(mapping_positions),
        options_(options),
        keyed_(has_key_scans(log)) {}

  StartRecord run(std::size_t start) {
    record_.start = order_[start];
    record_.near_m = nearest_mapping(scan_at(start));
    robot_ = options_.make_robot ? options_.make_robot(scan_at(start)) : make_localizer();
    const double begin_stamp = scan_at(start).scan.stamp;
    std::size_t waiting = 0;
    for (std::size_t k = start; k < order_.size(); ++k) {
      if (k > start && order_[k] != order_[k - 1] + 1) break;  // the rest is not one drive any more
      const LogScan& scan = scan_at(k);
      if (k > start) record_.driven_m += distance(*scan.T_map_laser, *scan_at(k - 1).T_map_laser);
      const Answer answer = take(scan);
      const bool key = !keyed_ || scan.is_key_scan;
      if (++waiting < options_.batch && !(keyed_ && key)) continue;
      waiting = 0;
      if (!judge(answer, scan, key, begin_stamp)) break;
      const double driven = record_.driven_m;
      if (fixed_ && !said_ && driven > *record_.way_m + options_.track_m) break;
      if (!fixed_ && (driven > options_.way_m || scan.scan.stamp - begin_stamp > options_.time_s))
        break;
    }
    if (said_) give_verdict(said_->pose, said_->map, said_->truth, kLooseAngle);
    return std::move(record_);
  }

 private:
  struct Said {
    Pose2 pose;
    LocalizationMapPtr map;
    Pose2 truth;
  };

  [[nodiscard]] const LogScan& scan_at(std::size_t k) const { return log_.scans[order_[k]]; }

  [[nodiscard]] ScoredRobot make_localizer() const {
    LocalizerParams params = options_.localizer;
    if (options_.sample) params.acceptance.min_gap = std::numeric_limits<double>::infinity();
    const auto localizer = std::make_shared<Localizer>(maps_, params);
    return [localizer](const RobotScan& scan) { return localizer->process(scan); };
  }

  [[nodiscard]] double nearest_mapping(const LogScan& scan) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Point2& mapped : mapping_positions_) {
      nearest = std::min(nearest, (mapped - scan.T_map_laser->translation()).norm());
    }
    return nearest;
  }

  void take_sample(const Answer& answer, const LogScan& scan) {
    if (!answer.searched || answer.hypotheses.empty()) return;
    const RankedHypothesis& best = answer.hypotheses.front();
    const Error2 error = error_of(best.T_map_base_link, *scan.T_map_laser);
    const bool right =
        best.map == maps_[right_map_] && error.m <= kRightDistance && error.rad <= kLooseAngle;
    record_.samples.push_back(
        {record_.driven_m, nearest_mapping(scan), right, best.evidence,
         answer.hypotheses.size() > 1 ? answer.hypotheses[1].evidence : EvidenceScore{}});
  }

  Answer take(const LogScan& scan) {
    RobotScan robot_scan{scan.scan, {}, {}};
    if (options_.mirror) std::reverse(robot_scan.scan.ranges.begin(), robot_scan.scan.ranges.end());
    if (options_.use_odometry) robot_scan.T_odom_base_link = scan.T_odom_laser;
    const auto asked = std::chrono::steady_clock::now();
    const double begin = thread_ms();
    Answer answer = robot_(robot_scan);
    (fixed_ ? record_.tracking_ms : record_.searching_ms).push_back(thread_ms() - begin);
    const std::chrono::duration<double, std::milli> waited =
        std::chrono::steady_clock::now() - asked;
    record_.round_trip_ms.push_back(waited.count());
    record_.reason = answer.reason;
    ++record_.scans;
    if (options_.sample) take_sample(answer, scan);
    return answer;
  }

  /// No map holds the place of a mirrored scan or of a log from elsewhere.
  [[nodiscard]] bool is_right_map(const LocalizationMapPtr& map) const {
    return !options_.mirror && right_map_ != kNoMap && map == maps_[right_map_];
  }

  /// False when the drive is over.
  bool judge(const Answer& answer, const LogScan& scan, bool key, double begin_stamp) {
    if (answer.status != Status::kLocalized) {
      if (!said_) return true;
      const Said said = *said_;  // taken back before a key scan came: judged where it was said
      said_.reset();
      return give_verdict(said.pose, said.map, said.truth, kLooseAngle);
    }
    const LocalizedPose& pose = *answer.pose;
    if (!fixed_) {
      fixed_ = true;
      record_.way_m = record_.driven_m;
      record_.seconds = scan.scan.stamp - begin_stamp;
      record_.confidence = answer.confidence;
      said_ = Said{pose.T_map_base_link, pose.map, *scan.T_map_laser};
    }
    if (!key) return true;
    if (said_) {
      said_.reset();
      return give_verdict(pose.T_map_base_link, pose.map, *scan.T_map_laser, kRightAngle);
    }
    const Error2 error = error_of(pose.T_map_base_link, *scan.T_map_laser);
    const bool right =
        pose.map == maps_[right_map_] && error.m <= kRightDistance && error.rad <= kRightAngle;
    ++(right ? record_.right_after : record_.wrong_after);
    record_.nees.push_back(nees_of(pose, *scan.T_map_laser));
    return true;
  }

  bool give_verdict(const Pose2& pose, const LocalizationMapPtr& map, const Pose2& truth,
                    double angle) {
    const Error2 error = error_of(pose, truth);
    const bool right = is_right_map(map) && error.m <= kRightDistance && error.rad <= angle;
    record_.verdict = right ? Verdict::kFixed : Verdict::kFalse;
    record_.error_m = error.m;
    record_.error_rad = error.rad;
    record_.pose = pose;
    record_.truth = truth;
    return right;
  }

  const RecordedLog& log_;
  std::span<const std::size_t> order_;
  const std::vector<LocalizationMapPtr>& maps_;
  std::size_t right_map_;
  const std::vector<Point2>& mapping_positions_;
  const EvaluationOptions& options_;
  bool keyed_;
  ScoredRobot robot_;
  StartRecord record_;
  bool fixed_ = false;
  std::optional<Said> said_;  ///< The first `localized` answer until it is judged.
};

}  // namespace

std::size_t split_index(const RecordedLog& log, double share) {
  std::size_t posed = 0;
  for (const LogScan& scan : log.scans) posed += scan.T_map_laser ? 1 : 0;
  const auto wanted = static_cast<std::size_t>(static_cast<double>(posed) * share);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < log.scans.size(); ++i) {
    if (seen == wanted) return i;
    if (log.scans[i].T_map_laser) ++seen;
  }
  return log.scans.size();
}

Evaluation map_from(const RecordedLog& log, std::size_t end, const MapperParams& params) {
  return map_from(log, posed_scans(log, 0, end), params);
}

Evaluation map_from(const RecordedLog& log, std::span<const std::size_t> mapping,
                    const MapperParams& params, const ShareDone& progress) {
  const bool keyed = has_key_scans(log);
  const double begin = thread_ms();
  Evaluation evaluation;
  Mapper mapper(params);
  for (std::size_t k = 0; k < mapping.size(); ++k) {
    const LogScan& scan = log.scans[mapping[k]];
    if (progress) progress(k + 1, mapping.size());
    if (keyed && !scan.is_key_scan) continue;
    evaluation.mapping_positions.push_back(scan.T_map_laser->translation());
    PosedScan posed{scan.scan, {}, *scan.T_map_laser};
    if (mapper.is_key_frame(posed)) mapper.add(std::move(posed));
  }
  evaluation.map = std::make_shared<const LocalizationMap>(log.header.name, 1, mapper.build());
  evaluation.key_frames = mapper.key_frames();
  evaluation.map_seconds = 1e-3 * (thread_ms() - begin);
  return evaluation;
}

Result<Evaluation> map_from_floor_map(const std::filesystem::path& yaml, const RecordedLog& log,
                                      const MapperParams& params) {
  const Result<OccupancyGrid> floor_map = read_map_files(yaml);
  if (!floor_map) return floor_map.error();
  const double begin = processor_ms(CLOCK_PROCESS_CPUTIME_ID);  // on all cores
  Result<GridMap> map = map_from_grid(*floor_map, params);
  if (!map) return map.error();
  for (const std::string& warning : map->warnings)
    std::fprintf(stderr, "%s: %s\n", yaml.c_str(), warning.c_str());
  Evaluation evaluation;
  evaluation.map =
      std::make_shared<const LocalizationMap>(log.header.name, 1, std::move(map->content));
  const OccupancyGrid& grid = evaluation.map->grid();
  const Pose2 T_grid_map = inverse(grid.T_map_grid);
  for (const LogScan& scan : log.scans) {
    if (!scan.T_map_laser) continue;
    const Point2 position_map = scan.T_map_laser->translation();
    if (grid.at(grid.cell_of(T_grid_map * position_map)) == Cell::kFree)
      evaluation.mapping_positions.push_back(position_map);
  }
  evaluation.map_seconds = 1e-3 * (processor_ms(CLOCK_PROCESS_CPUTIME_ID) - begin);
  return evaluation;
}

std::vector<StartRecord> evaluate(const RecordedLog& log, std::size_t begin,
                                  const std::vector<LocalizationMapPtr>& maps,
                                  std::size_t right_map,
                                  const std::vector<Point2>& mapping_positions,
                                  const EvaluationOptions& options, const ShareDone& progress) {
  return evaluate(log, posed_scans(log, begin, log.scans.size()), maps, right_map,
                  mapping_positions, options, progress);
}

std::vector<StartRecord> evaluate(const RecordedLog& log, std::span<const std::size_t> order,
                                  const std::vector<LocalizationMapPtr>& maps,
                                  std::size_t right_map,
                                  const std::vector<Point2>& mapping_positions,
                                  const EvaluationOptions& options, const ShareDone& progress) {
  if (order.empty()) return {};
  const std::size_t usable = order.size() > options.batch ? order.size() - options.batch : 1;
  const std::size_t count = std::min(options.starts, usable);
  std::vector<StartRecord> records(count);
  std::atomic<std::size_t> next{0};
  std::mutex progress_mutex;
  std::size_t done = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      const std::size_t start = i * usable / count;
      records[i] = Drive(log, order, maps, right_map, mapping_positions, options).run(start);
      const std::lock_guard lock(progress_mutex);
      if (progress) progress(++done, count);
    }
  };
  std::vector<std::thread> threads;
  for (std::size_t i = 1; i < options.threads; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  return records;
}

}  // namespace cornerfix::cli
