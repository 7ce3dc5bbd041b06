#include "cli/evaluation_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>

#include "cli/degrees.hpp"

namespace cornerfix::cli {

namespace {

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kFixed:
      return "fixed";
    case Verdict::kFalse:
      return "false";
    case Verdict::kNone:
      break;
  }
  return "none";
}

nlohmann::ordered_json pose_array(const Pose2& pose) { return {pose.x, pose.y, pose.yaw}; }

template <typename Value>
nlohmann::ordered_json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

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

nlohmann::ordered_json summary_json(const std::string& log_name, const Evaluation& evaluation,
                                    const EvaluationOptions& options) {
  std::size_t inside = 0;
  std::size_t outside = 0;
  std::size_t outside_false = 0;
  std::size_t fixed = 0;
  std::size_t wrong = 0;
  std::size_t none = 0;
  nlohmann::ordered_json none_reasons = nlohmann::ordered_json::object();
  std::size_t within_1m = 0;
  std::size_t within_5m = 0;
  std::size_t right_after = 0;
  std::size_t wrong_after = 0;
  std::vector<double> nees;
  std::size_t scans = 0;
  std::vector<double> ways;
  std::vector<double> seconds;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;
  std::vector<double> searching;
  std::vector<double> tracking;
  std::vector<double> round_trips;
  for (const StartRecord& record : evaluation.records) {
    scans += record.scans;
    right_after += record.right_after;
    wrong_after += record.wrong_after;
    nees.insert(nees.end(), record.nees.begin(), record.nees.end());
    searching.insert(searching.end(), record.searching_ms.begin(), record.searching_ms.end());
    tracking.insert(tracking.end(), record.tracking_ms.begin(), record.tracking_ms.end());
    round_trips.insert(round_trips.end(), record.round_trip_ms.begin(), record.round_trip_ms.end());
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
    if (record.verdict == Verdict::kNone) {
      nlohmann::ordered_json& count = none_reasons[std::string(to_string(record.reason))];
      count = count.is_null() ? 1 : count.get<int>() + 1;
    }
    if (record.verdict != Verdict::kFixed) continue;
    ++fixed;
    ways.push_back(*record.way_m);
    seconds.push_back(*record.seconds);
    within_1m += *record.way_m <= 1.0 ? 1 : 0;
    within_5m += *record.way_m <= 5.0 ? 1 : 0;
    errors_m.push_back(record.error_m);
    errors_deg.push_back(record.error_rad * kDegreesPerRadian);
  }
  std::vector<double> all_ms = searching;
  all_ms.insert(all_ms.end(), tracking.begin(), tracking.end());
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
  return {
      {"log", log_name},
      {"split", evaluation.split},
      {"map_scans", evaluation.mapping_positions.size()},
      {"map_seconds", evaluation.map_seconds},
      {"features", evaluation.map->features().size()},
      {"starts", inside},
      {"fixed", fixed},
      {"false", wrong},
      {"none", none},
      {"none_reasons", none_reasons},
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
      {"nees", quantiles(nees, 0.95, "p95")},
      {"server_ms_per_scan", costs(all_ms)},
      {"searching_ms_per_scan", costs(searching)},
      {"tracking_ms_per_scan", costs(tracking)},
      {"rtt_ms_per_scan", quantiles(round_trips, 0.95, "p95")},
      {"scans", scans},
      {"wall_s", std::round(10.0 * evaluation.wall_s) / 10.0},
  };
}

nlohmann::ordered_json record_json(const StartRecord& record) {
  std::vector<double> ms = record.searching_ms;
  ms.insert(ms.end(), record.tracking_ms.begin(), record.tracking_ms.end());
  nlohmann::ordered_json json{
      {"start", record.start},
      {"near", record.near_m},
      {"result", to_string(record.verdict)},
      {"way", or_null(record.way_m)},
      {"seconds", or_null(record.seconds)},
      {"scans", record.scans},
      {"ms", std::move(ms)},
      {"rtt_ms", record.round_trip_ms},
      {"wrong_after", record.wrong_after},
      {"right_after", record.right_after},
      {"err", nlohmann::ordered_json::array()},
      {"driven", record.driven_m},
  };
  if (record.verdict == Verdict::kNone) {
    json["reason"] = to_string(record.reason);
    return json;
  }
  json["err"].push_back({record.error_m, record.error_rad * kDegreesPerRadian});
  json["confidence"] = record.confidence;
  json["pose"] = pose_array(record.pose);
  json["truth"] = pose_array(record.truth);
  return json;
}

void write_records(std::ostream& csv, const std::vector<StartRecord>& records) {
  csv << "start,near_m,verdict,way_m,seconds,driven_m,confidence,error_m,error_rad,x,y,yaw,true_x,"
         "true_y,true_yaw,scans,right_after,wrong_after,reason\n";
  for (const StartRecord& record : records) {
    csv << record.start << ',' << record.near_m << ',' << to_string(record.verdict) << ',';
    if (record.way_m) csv << *record.way_m;
    csv << ',';
    if (record.seconds) csv << *record.seconds;
    csv << ',' << record.driven_m << ',' << record.confidence << ',' << record.error_m << ','
        << record.error_rad;
    for (const Pose2& pose : {record.pose, record.truth})
      csv << ',' << pose.x << ',' << pose.y << ',' << pose.yaw;
    csv << ',' << record.scans << ',' << record.right_after << ',' << record.wrong_after << ','
        << (record.verdict == Verdict::kNone ? to_string(record.reason) : "") << '\n';
  }
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

}  // namespace cornerfix::cli
