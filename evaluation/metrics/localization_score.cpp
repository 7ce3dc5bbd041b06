#include "evaluation/metrics/localization_score.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numeric>

#include <cornerfix/map_image.hpp>
#include <cornerfix/mapper.hpp>

#include "evaluation/datasets/log_split.hpp"
#include "evaluation/metrics/processor_time.hpp"

namespace cornerfix::evaluation {
namespace {

bool has_key_scans(const RecordedLog& log) {
  return std::any_of(log.scans.begin(), log.scans.end(),
                     [](const LogScan& scan) { return scan.is_key_scan; });
}

/// Whether the scan at position `k` follows the one before it; otherwise another run begins.
bool continues_at(std::span<const std::size_t> order, std::size_t k) {
  return order[k] == order[k - 1] + 1;
}

/// One robot from its switch-on to its verdict.
class StartedRobot {
 public:
  StartedRobot(const RecordedLog& log, std::span<const std::size_t> order,
               const std::vector<LocalizationMapPtr>& maps, std::size_t right_map,
               const std::vector<Point2>& mapping_positions, const EvaluationOptions& options)
      : log_(log),
        order_(order),
        maps_(maps),
        right_map_(right_map),
        mapping_positions_(mapping_positions),
        options_(options),
        keyed_(has_key_scans(log)),
        judge_(is_in_a_map() ? maps[right_map] : nullptr) {}

  StartRecord run(std::size_t start) {
    record_.start = order_[start];
    record_.near_m = nearest_mapping(scan_at(start));
    if (options_.odometry_fault) fault_.emplace(*options_.odometry_fault, record_.start);
    robot_ = options_.make_robot ? options_.make_robot(scan_at(start)) : make_localizer();
    std::size_t waiting = 0;
    for (std::size_t k = start; k < order_.size(); ++k) {
      if (k > start && !continues_at(order_, k)) break;
      const LogScan& scan = scan_at(k);
      if (k > start)
        record_.distance_traveled_m += distance(*scan.T_map_laser, *scan_at(k - 1).T_map_laser);
      const Answer answer = take(scan);
      const bool key = !keyed_ || scan.is_key_scan;
      if (++waiting < options_.batch && !(keyed_ && key)) continue;
      waiting = 0;
      const double elapsed_s = scan.scan.stamp - scan_at(start).scan.stamp;
      judge_.take(answer, *scan.T_map_laser, key, record_.distance_traveled_m);
      note_first_localized(answer, elapsed_s);
      if (is_over(elapsed_s)) break;
    }
    judge_.finish();
    note_judged_answers();
    return std::move(record_);
  }

 private:
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

  [[nodiscard]] std::optional<Pose2> odometry_at(const LogScan& scan) {
    if (!options_.use_odometry || !scan.T_odom_laser) return std::nullopt;
    if (!fault_) return scan.T_odom_laser;
    return fault_->corrupt(scan.scan.stamp, *scan.T_odom_laser);
  }

  /// What a search of the whole map believed, and whether it was right.
  void note_search(const Answer& answer, const LogScan& scan) {
    if (!answer.searched || answer.hypotheses.empty()) return;
    const RankedHypothesis& best = answer.hypotheses.front();
    const bool right = is_in_a_map() && best.map == maps_[right_map_] &&
                       is_correct(pose_error(best.T_map_base_link, *scan.T_map_laser),
                                  kCorrectAngleBetweenKeyframes);
    record_.searches.push_back({answer.confidence, right});
    if (!options_.sample) return;
    record_.samples.push_back(
        {record_.distance_traveled_m, nearest_mapping(scan), right, best.evidence,
         answer.hypotheses.size() > 1 ? answer.hypotheses[1].evidence : EvidenceScore{},
         answer.terms});
  }

  Answer take(const LogScan& scan) {
    RobotScan robot_scan{scan.scan, {}, {}};
    if (options_.mirror) std::reverse(robot_scan.scan.ranges.begin(), robot_scan.scan.ranges.end());
    robot_scan.T_odom_base_link = odometry_at(scan);
    const auto asked = std::chrono::steady_clock::now();
    const double begin = thread_ms();
    Answer answer = robot_(robot_scan);
    (record_.localized_after_m ? record_.tracking_ms : record_.searching_ms)
        .push_back(thread_ms() - begin);
    const std::chrono::duration<double, std::milli> waited =
        std::chrono::steady_clock::now() - asked;
    record_.round_trip_ms.push_back(waited.count());
    record_.reason = answer.reason;
    ++record_.scans;
    note_search(answer, scan);
    return answer;
  }

  /// No map holds the surroundings of a mirrored scan or of a log from elsewhere.
  [[nodiscard]] bool is_in_a_map() const { return !options_.mirror && right_map_ != kNoMap; }

  void note_first_localized(const Answer& answer, double elapsed_s) {
    if (record_.localized_after_m || !judge_.localized_at_m()) return;
    record_.localized_after_m = judge_.localized_at_m();
    record_.localized_after_s = elapsed_s;
    record_.confidence = answer.confidence;
  }

  /// A robot with a wrong pose is followed until it is known whether it withdraws the pose in time.
  [[nodiscard]] bool is_over(double elapsed_s) const {
    if (!record_.localized_after_m)
      return record_.distance_traveled_m > options_.max_distance_m ||
             elapsed_s > options_.max_time_s;
    const bool is_open = judge_.is_pending() || judge_.withdrawal() == Withdrawal::kUndecided;
    return !is_open && record_.distance_traveled_m > *record_.localized_after_m + options_.track_m;
  }

  void note_judged_answers() {
    record_.answers_judged = judge_.judged();
    record_.wrong_answers = judge_.wrong();
    record_.first_wrong = judge_.first_wrong();
    record_.longest_wrong_m = judge_.longest_wrong_m();
    record_.withdrawal = judge_.withdrawal();
    record_.nees = judge_.nees_after_first();
    record_.localized = judge_.forecasts();
    const auto& first = judge_.first();
    if (!first) return;
    record_.verdict = first->correct ? Verdict::kCorrect : Verdict::kWrong;
    record_.error_m = first->error.m;
    record_.error_rad = first->error.rad;
    record_.pose = first->pose;
    record_.truth = first->reference;
    record_.wrong_after = judge_.wrong() - (first->correct ? 0 : 1);
    record_.right_after = judge_.judged() - 1 - record_.wrong_after;
  }

  const RecordedLog& log_;
  std::span<const std::size_t> order_;
  const std::vector<LocalizationMapPtr>& maps_;
  std::size_t right_map_;
  const std::vector<Point2>& mapping_positions_;
  const EvaluationOptions& options_;
  bool keyed_;
  ScoredRobot robot_;
  std::optional<OdometryFault> fault_;
  AnswerJudge judge_;
  StartRecord record_;
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

std::vector<std::size_t> countable_starts(const RecordedLog& log,
                                          std::span<const std::size_t> asking,
                                          double max_distance_m, double max_time_s) {
  const auto scan_at = [&](std::size_t k) -> const LogScan& { return log.scans[asking[k]]; };
  std::vector<double> distance_traveled_m(asking.size(), 0.0);
  for (std::size_t k = 1; k < asking.size(); ++k) {
    distance_traveled_m[k] =
        distance_traveled_m[k - 1] + distance(*scan_at(k).T_map_laser, *scan_at(k - 1).T_map_laser);
  }
  std::vector<std::size_t> starts;
  std::size_t last = asking.size();  // of the run that k belongs to
  for (std::size_t k = asking.size(); k-- > 0;) {
    if (k + 1 == asking.size() || !continues_at(asking, k + 1)) last = k;
    if (distance_traveled_m[last] - distance_traveled_m[k] >= max_distance_m ||
        scan_at(last).scan.stamp - scan_at(k).scan.stamp >= max_time_s)
      starts.push_back(k);
  }
  std::ranges::reverse(starts);
  return starts;
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
  evaluation.keyframes = mapper.key_frames();
  evaluation.map_seconds = 1e-3 * (thread_ms() - begin);
  return evaluation;
}

Result<Evaluation> map_from_occupancy_map(const std::filesystem::path& yaml, const RecordedLog& log,
                                          const MapperParams& params) {
  const Result<OccupancyGrid> occupancy_map = read_map_files(yaml);
  if (!occupancy_map) return occupancy_map.error();
  const double begin = processor_ms(CLOCK_PROCESS_CPUTIME_ID);  // on all cores
  Result<GridMap> map = map_from_grid(*occupancy_map, params);
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
  std::vector<std::size_t> starts =
      countable_starts(log, order, options.max_distance_m, options.max_time_s);
  const bool counts = !starts.empty();
  if (!counts) {
    starts.resize(order.size());
    std::iota(starts.begin(), starts.end(), std::size_t{0});
  }
  const std::size_t count = std::min(options.starts, starts.size());
  std::vector<StartRecord> records(count);
  const auto ask = [&](std::size_t i) {
    const std::size_t start = starts[i * starts.size() / count];
    records[i] = StartedRobot(log, order, maps, right_map, mapping_positions, options).run(start);
    records[i].counts = counts;
  };
  in_parallel(count, options.threads, ask, progress);
  return records;
}

}  // namespace cornerfix::evaluation
