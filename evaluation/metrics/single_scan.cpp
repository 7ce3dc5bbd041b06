#include "evaluation/metrics/single_scan.hpp"

#include <algorithm>
#include <limits>

#include "evaluation/metrics/confidence_interval.hpp"
#include "evaluation/metrics/degrees.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/metrics/processor_time.hpp"

namespace cornerfix::evaluation {

namespace {

/// Positions whose reference is exact.
std::vector<std::size_t> exact_scans(const RecordedLog& log, std::span<const std::size_t> asking) {
  std::vector<std::size_t> scans(asking.begin(), asking.end());
  const bool has_keyframes = std::ranges::any_of(log.scans, &LogScan::is_key_scan);
  if (has_keyframes) std::erase_if(scans, [&](std::size_t i) { return !log.scans[i].is_key_scan; });
  return scans;
}

double nearest_m(const std::vector<Point2>& positions, const Point2& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Point2& position : positions) nearest = std::min(nearest, (position - point).norm());
  return nearest;
}

void note_best(SingleScanRecord& record, const Answer& answer, const LocalizationMap* right_map,
               const Pose2& reference) {
  record.accepted = answer.status == Status::kLocalized;
  record.confidence = answer.confidence;
  if (answer.hypotheses.empty()) return;
  const RankedHypothesis& best = answer.hypotheses.front();
  record.in_right_map = right_map != nullptr && best.map.get() == right_map;
  record.error = pose_error(best.T_map_base_link, reference);
}

/// Counts of one kind of starts: in the mapped part or not.
nlohmann::ordered_json counts_json(const std::vector<SingleScanRecord>& records) {
  const auto count = [&](const auto& is_such) {
    return static_cast<std::size_t>(std::ranges::count_if(records, is_such));
  };
  const auto share = [&](std::size_t hits) {
    const auto bounds = clopper_pearson(hits, records.size());
    return nlohmann::ordered_json{bounds.lower, bounds.upper};
  };
  const std::size_t right = count([](const auto& r) { return r.is_right(); });
  const std::size_t silent = count([](const auto& r) { return !r.error; });
  const std::size_t accepted_right =
      count([](const auto& r) { return r.accepted && r.is_right(); });
  const std::size_t accepted_wrong =
      count([](const auto& r) { return r.accepted && !r.is_right(); });
  return {{"scans", records.size()},
          {"top1_right", right},
          {"top1_wrong", records.size() - right - silent},
          {"top1_none", silent},
          {"top1_right_interval", share(right)},
          {"top1_right_heading", count([](const auto& r) { return r.has_right_heading(); })},
          {"accepted_right", accepted_right},
          {"accepted_wrong", accepted_wrong},
          {"accepted_right_heading",
           count([](const auto& r) { return r.accepted && r.has_right_heading(); })},
          {"accepted_right_interval", share(accepted_right)},
          {"accepted_wrong_interval", share(accepted_wrong)}};
}

nlohmann::ordered_json quantiles(const std::vector<double>& values) {
  return {{"p50", percentile(values, 0.5)},
          {"p95", percentile(values, 0.95)},
          {"max", percentile(values, 1.0)}};
}

}  // namespace

std::vector<SingleScanRecord> evaluate_single_scans(const RecordedLog& log,
                                                    std::span<const std::size_t> asking,
                                                    const std::vector<LocalizationMapPtr>& maps,
                                                    std::size_t right_map,
                                                    const std::vector<Point2>& mapping_positions,
                                                    const EvaluationOptions& options,
                                                    const ShareDone& progress) {
  const std::vector<std::size_t> scans = exact_scans(log, asking);
  const bool is_in_a_map = !options.mirror && right_map != kNoMap;
  std::vector<SingleScanRecord> records(std::min(options.starts, scans.size()));
  const auto ask = [&](std::size_t i) {
    SingleScanRecord& record = records[i];
    record.scan = scans[i * scans.size() / records.size()];
    const LogScan& scan = log.scans[record.scan];
    record.near_m = nearest_m(mapping_positions, scan.T_map_laser->translation());
    RobotScan robot_scan{scan.scan, {}, {}};
    if (options.mirror) std::ranges::reverse(robot_scan.scan.ranges);
    Localizer localizer(maps, options.localizer);
    const double begin = thread_ms();
    const Answer answer = localizer.process(robot_scan);
    record.ms = thread_ms() - begin;
    note_best(record, answer, is_in_a_map ? maps[right_map].get() : nullptr, *scan.T_map_laser);
  };
  in_parallel(records.size(), options.threads, ask, progress);
  return records;
}

nlohmann::ordered_json single_scan_summary_json(const std::string& log_name,
                                                const std::vector<SingleScanRecord>& records,
                                                double near_m) {
  std::vector<SingleScanRecord> mapped;
  std::vector<SingleScanRecord> outside;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;
  std::vector<double> ms;
  for (const SingleScanRecord& record : records) {
    ms.push_back(record.ms);
    (record.near_m <= near_m ? mapped : outside).push_back(record);
    if (record.near_m > near_m || !record.is_right()) continue;
    errors_m.push_back(record.error->m);
    errors_deg.push_back(record.error->rad * kDegreesPerRadian);
  }
  return {{"log", log_name},
          {"protocol", "single scan"},
          {"mapped", counts_json(mapped)},
          {"outside", counts_json(outside)},
          {"error_m", quantiles(errors_m)},
          {"error_deg", quantiles(errors_deg)},
          {"ms_per_scan", quantiles(ms)}};
}

nlohmann::ordered_json single_scan_record_json(const SingleScanRecord& record) {
  nlohmann::ordered_json json{{"scan", record.scan},
                              {"near", record.near_m},
                              {"accepted", record.accepted},
                              {"right", record.is_right()},
                              {"confidence", record.confidence},
                              {"ms", record.ms}};
  if (record.error) json["err"] = {record.error->m, record.error->rad * kDegreesPerRadian};
  return json;
}

}  // namespace cornerfix::evaluation
