#include "cli/evaluation.hpp"

#include <cornerfix/grid_mapping.hpp>
#include <cornerfix/map_image.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <ostream>
#include <thread>

namespace cornerfix::cli {
namespace {

constexpr double kRightDistance = 0.5;  // [m]
constexpr double kRightAngle = 5.0 * std::numbers::pi / 180.0;
constexpr double kLooseAngle =
    15.0 * std::numbers::pi / 180.0;  // between key scans, whose headings are interpolated

/// Processor time of this thread: what a scan costs, whatever else the machine does.
double thread_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

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

/// One robot from its switch-on to its verdict.
class Drive {
 public:
  Drive(const RecordedLog& log, const std::vector<std::size_t>& order,
        const std::vector<LocalizationMapPtr>& maps, std::size_t right_map,
        const std::vector<Point2>& mapping_positions, const EvaluationOptions& options)
      : log_(log),
        order_(order),
        maps_(maps),
        right_map_(right_map),
        mapping_positions_(mapping_positions),
        options_(options),
        keyed_(has_key_scans(log)),
        localizer_(maps, localizer_params(options)) {}

  StartRecord run(std::size_t start) {
    record_.start = order_[start];
    record_.near_m = nearest_mapping(scan_at(start));
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

  static LocalizerParams localizer_params(const EvaluationOptions& options) {
    LocalizerParams params = options.localizer;
    if (options.sample) params.acceptance.min_gap = std::numeric_limits<double>::infinity();
    return params;
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
    const double begin = thread_ms();
    Answer answer = localizer_.process(robot_scan);
    (fixed_ ? record_.tracking_ms : record_.searching_ms).push_back(thread_ms() - begin);
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
  const std::vector<std::size_t>& order_;
  const std::vector<LocalizationMapPtr>& maps_;
  std::size_t right_map_;
  const std::vector<Point2>& mapping_positions_;
  const EvaluationOptions& options_;
  bool keyed_;
  Localizer localizer_;
  StartRecord record_;
  bool fixed_ = false;
  std::optional<Said> said_;  ///< The first `localized` answer until it is judged.
};

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  return values[std::min(values.size() - 1, index)];
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : sum / static_cast<double>(values.size());
}

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
  const bool keyed = has_key_scans(log);
  const double begin = thread_ms();
  Evaluation evaluation;
  Mapper mapper(params);
  for (std::size_t i = 0; i < end; ++i) {
    const LogScan& scan = log.scans[i];
    if (!scan.T_map_laser || (keyed && !scan.is_key_scan)) continue;
    evaluation.mapping_positions.push_back(scan.T_map_laser->translation());
    PosedScan posed{scan.scan, {}, *scan.T_map_laser};
    if (mapper.is_key_frame(posed)) mapper.add(std::move(posed));
  }
  evaluation.map = std::make_shared<const LocalizationMap>(log.header.name, 1, mapper.build());
  evaluation.map_seconds = 1e-3 * (thread_ms() - begin);
  return evaluation;
}

Result<Evaluation> map_from_floor_map(const std::filesystem::path& yaml, const RecordedLog& log,
                                      const MapperParams& params) {
  const Result<OccupancyGrid> floor_map = read_map_files(yaml);
  if (!floor_map) return floor_map.error();
  const double begin = thread_ms();
  Result<GridMap> map = map_from_grid(*floor_map, params);
  if (!map) return map.error();
  for (const std::string& warning : map->warnings)
    std::fprintf(stderr, "%s: %s\n", yaml.c_str(), warning.c_str());
  Evaluation evaluation;
  for (const LogScan& scan : log.scans) {
    if (scan.T_map_laser) evaluation.mapping_positions.push_back(scan.T_map_laser->translation());
  }
  evaluation.map =
      std::make_shared<const LocalizationMap>(log.header.name, 1, std::move(map->content));
  evaluation.map_seconds = 1e-3 * (thread_ms() - begin);
  return evaluation;
}

std::vector<StartRecord> evaluate(const RecordedLog& log, std::size_t begin,
                                  const std::vector<LocalizationMapPtr>& maps,
                                  std::size_t right_map,
                                  const std::vector<Point2>& mapping_positions,
                                  const EvaluationOptions& options,
                                  const std::function<void(std::size_t, std::size_t)>& progress) {
  std::vector<std::size_t> order;
  for (std::size_t i = begin; i < log.scans.size(); ++i) {
    if (log.scans[i].T_map_laser) order.push_back(i);
  }
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

void write_samples(std::ostream& csv, const std::string& name,
                   const std::vector<StartRecord>& records, bool header) {
  if (header) {
    csv << "log,start,way_m,near_m,right";
    for (const char* place : {"best", "second"}) {
      for (std::size_t i = 0; i < kEndClasses; ++i) csv << ',' << place << "_end" << i;
      for (std::size_t i = 0; i < kPassClasses; ++i) csv << ',' << place << "_pass" << i;
    }
    csv << '\n';
  }
  for (const StartRecord& record : records) {
    for (const DecisionSample& sample : record.samples) {
      csv << name << ',' << record.start << ',' << sample.way_m << ',' << sample.near_m << ','
          << sample.right;
      for (const EvidenceScore* score : {&sample.best, &sample.second}) {
        for (const int count : score->end_counts) csv << ',' << count;
        for (const int count : score->pass_counts) csv << ',' << count;
      }
      csv << '\n';
    }
  }
}

std::string summary_json(const std::string& log_name, const Evaluation& evaluation,
                         const EvaluationOptions& options) {
  std::size_t inside = 0;
  std::size_t outside = 0;
  std::size_t outside_false = 0;
  std::size_t fixed = 0;
  std::size_t wrong = 0;
  std::size_t none = 0;
  std::size_t within_1m = 0;
  std::size_t within_5m = 0;
  std::size_t right_after = 0;
  std::size_t wrong_after = 0;
  std::size_t scans = 0;
  std::vector<double> ways;
  std::vector<double> seconds;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;
  std::vector<double> searching;
  std::vector<double> tracking;
  for (const StartRecord& record : evaluation.records) {
    scans += record.scans;
    right_after += record.right_after;
    wrong_after += record.wrong_after;
    searching.insert(searching.end(), record.searching_ms.begin(), record.searching_ms.end());
    tracking.insert(tracking.end(), record.tracking_ms.begin(), record.tracking_ms.end());
    if (record.near_m > options.near_m) {
      ++outside;
      outside_false += record.verdict == Verdict::kFalse ? 1 : 0;
      continue;
    }
    // A start that ran out of log before the allowed way and got no answer tells nothing.
    if (record.verdict == Verdict::kNone && record.driven_m < 0.5 * options.way_m) continue;
    ++inside;
    wrong += record.verdict == Verdict::kFalse ? 1 : 0;
    none += record.verdict == Verdict::kNone ? 1 : 0;
    if (record.verdict != Verdict::kFixed) continue;
    ++fixed;
    ways.push_back(*record.way_m);
    seconds.push_back(*record.seconds);
    within_1m += *record.way_m <= 1.0 ? 1 : 0;
    within_5m += *record.way_m <= 5.0 ? 1 : 0;
    errors_m.push_back(record.error_m);
    errors_deg.push_back(record.error_rad * 180.0 / std::numbers::pi);
  }
  const auto share = [inside](std::size_t part) {
    return std::round(1e4 * static_cast<double>(part) /
                      static_cast<double>(std::max<std::size_t>(1, inside))) /
           1e4;
  };
  const auto quantiles = [](const std::vector<double>& values, double high, const char* name) {
    return nlohmann::ordered_json{{"p50", percentile(values, 0.5)},
                                  {name, percentile(values, high)}};
  };
  const auto costs = [](const std::vector<double>& values) {
    return nlohmann::ordered_json{{"mean", mean(values)},
                                  {"p50", percentile(values, 0.5)},
                                  {"p95", percentile(values, 0.95)},
                                  {"max", percentile(values, 1.0)}};
  };
  const std::size_t after = std::max<std::size_t>(1, right_after + wrong_after);
  const nlohmann::ordered_json summary{
      {"log", log_name},
      {"split", options.split},
      {"map_scans", evaluation.mapping_positions.size()},
      {"map_seconds", evaluation.map_seconds},
      {"features", evaluation.map->features().size()},
      {"starts", inside},
      {"fixed", fixed},
      {"false", wrong},
      {"none", none},
      {"success", share(fixed)},
      {"success_1m", share(within_1m)},
      {"success_5m", share(within_5m)},
      {"outside", outside},
      {"outside_false", outside_false},
      {"way_m", quantiles(ways, 0.9, "p90")},
      {"seconds", quantiles(seconds, 0.9, "p90")},
      {"error_m", quantiles(errors_m, 0.95, "p95")},
      {"error_deg", quantiles(errors_deg, 0.95, "p95")},
      {"tracked_right",
       std::round(1e4 * static_cast<double>(right_after) / static_cast<double>(after)) / 1e4},
      {"searching_ms_per_scan", costs(searching)},
      {"tracking_ms_per_scan", costs(tracking)},
      {"scans", scans},
  };
  return summary.dump(1);
}

}  // namespace cornerfix::cli
