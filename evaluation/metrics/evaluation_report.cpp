#include "evaluation/metrics/evaluation_report.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "evaluation/metrics/confidence_interval.hpp"
#include "evaluation/metrics/degrees.hpp"
#include "evaluation/metrics/percentile.hpp"

namespace cornerfix::evaluation {

namespace {

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kCorrect:
      return "fixed";
    case Verdict::kWrong:
      return "false";
    case Verdict::kNone:
      break;
  }
  return "none";
}

const char* to_string(Withdrawal withdrawal) {
  switch (withdrawal) {
    case Withdrawal::kInTime:
      return "in_time";
    case Withdrawal::kLate:
      return "late";
    case Withdrawal::kUndecided:
      break;
  }
  return "undecided";
}

nlohmann::ordered_json pose_array(const Pose2& pose) { return {pose.x, pose.y, pose.yaw}; }

template <typename Value>
nlohmann::ordered_json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

double share(std::size_t part, std::size_t all) {
  return to_four_decimals(static_cast<double>(part) /
                          static_cast<double>(std::max<std::size_t>(1, all)));
}

nlohmann::ordered_json quantiles(const std::vector<double>& values, double high, const char* name) {
  return {{"p50", percentile(values, 0.5)}, {name, percentile(values, high)}};
}

nlohmann::ordered_json costs(const std::vector<double>& values) {
  return {{"mean", mean(values)},
          {"p50", percentile(values, 0.5)},
          {"p95", percentile(values, 0.95)},
          {"max", percentile(values, 1.0)}};
}

nlohmann::ordered_json interval(std::size_t hits, std::size_t trials) {
  const auto bounds = clopper_pearson(hits, trials);
  return {bounds.lower, bounds.upper};
}

void append(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// Of the starts in the mapped part.
struct MappedStarts {
  std::size_t starts = 0;
  std::size_t correct = 0;
  std::size_t wrong = 0;
  std::size_t none = 0;
  std::size_t within_1m = 0;
  std::size_t within_5m = 0;
  nlohmann::ordered_json none_reasons = nlohmann::ordered_json::object();
  std::vector<double> distances_m;
  std::vector<double> seconds;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;

  void add(const StartRecord& record) {
    ++starts;
    if (record.verdict == Verdict::kWrong) ++wrong;
    if (record.verdict == Verdict::kNone) add_silent(record.reason);
    if (record.verdict == Verdict::kCorrect) add_correct(record);
  }

 private:
  void add_silent(Reason reason) {
    ++none;
    nlohmann::ordered_json& count = none_reasons[std::string(to_string(reason))];
    count = count.is_null() ? 1 : count.get<int>() + 1;
  }

  void add_correct(const StartRecord& record) {
    ++correct;
    distances_m.push_back(*record.localized_after_m);
    seconds.push_back(*record.localized_after_s);
    within_1m += *record.localized_after_m <= 1.0 ? 1 : 0;
    within_5m += *record.localized_after_m <= 5.0 ? 1 : 0;
    errors_m.push_back(record.error_m);
    errors_deg.push_back(record.error_rad * kDegreesPerRadian);
  }
};

/// Of all `localized` answers of all starts that count, in the mapped part or not.
struct AllAnswers {
  std::size_t judged = 0;
  std::size_t wrong = 0;
  std::size_t starts_with_wrong = 0;
  std::size_t wrong_later = 0;  ///< Starts whose first answer was right, a later one not.
  std::size_t withdrawn_in_time = 0;
  std::size_t withdrawn_late = 0;
  std::size_t undecided = 0;
  std::vector<double> longest_wrong_m;
  std::vector<Forecast> searches;
  std::vector<Forecast> localized;

  void add(const StartRecord& record) {
    searches.insert(searches.end(), record.searches.begin(), record.searches.end());
    localized.insert(localized.end(), record.localized.begin(), record.localized.end());
    judged += record.answers_judged;
    wrong += record.wrong_answers;
    if (!record.first_wrong) return;
    ++starts_with_wrong;
    wrong_later += record.verdict == Verdict::kCorrect ? 1 : 0;
    withdrawn_in_time += record.withdrawal == Withdrawal::kInTime ? 1 : 0;
    withdrawn_late += record.withdrawal == Withdrawal::kLate ? 1 : 0;
    undecided += record.withdrawal == Withdrawal::kUndecided ? 1 : 0;
    longest_wrong_m.push_back(record.longest_wrong_m);
  }
};

/// Of every scan that was asked, whether its start counts or not.
struct AllScans {
  std::size_t scans = 0;
  std::size_t right_after = 0;
  std::size_t wrong_after = 0;
  std::vector<double> nees;
  std::vector<double> searching;
  std::vector<double> tracking;
  std::vector<double> round_trips;

  void add(const StartRecord& record) {
    scans += record.scans;
    right_after += record.right_after;
    wrong_after += record.wrong_after;
    append(nees, record.nees);
    append(searching, record.searching_ms);
    append(tracking, record.tracking_ms);
    append(round_trips, record.round_trip_ms);
  }

  [[nodiscard]] std::vector<double> ms() const {
    std::vector<double> all = searching;
    append(all, tracking);
    return all;
  }
};

struct Tally {
  MappedStarts mapped;
  std::size_t outside = 0;
  std::size_t outside_false = 0;
  AllAnswers answers;
  AllScans scans;
};

Tally tally_of(const std::vector<StartRecord>& records, double near_m) {
  Tally tally;
  for (const StartRecord& record : records) {
    tally.scans.add(record);
    if (!record.counts) continue;
    tally.answers.add(record);
    if (record.near_m <= near_m) {
      tally.mapped.add(record);
    } else {
      ++tally.outside;
      tally.outside_false += record.verdict == Verdict::kWrong ? 1 : 0;
    }
  }
  return tally;
}

nlohmann::ordered_json reliability_json(const std::vector<Forecast>& forecasts) {
  const auto bins = reliability_of(forecasts);
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const ReliabilityBin& bin : bins)
    rows.push_back({bin.from, bin.to, bin.forecasts, bin.correct, bin.mean_confidence});
  return {{"forecasts", forecasts.size()},
          {"ece", expected_calibration_error(bins)},
          {"bins", std::move(rows)}};
}

void add_starts(nlohmann::ordered_json& summary, const Tally& tally) {
  const MappedStarts& mapped = tally.mapped;
  summary["starts"] = mapped.starts;
  summary["fixed"] = mapped.correct;
  summary["false"] = mapped.wrong;
  summary["none"] = mapped.none;
  summary["none_reasons"] = mapped.none_reasons;
  summary["success"] = share(mapped.correct, mapped.starts);
  summary["success_interval"] = interval(mapped.correct, mapped.starts);
  summary["success_1m"] = share(mapped.within_1m, mapped.starts);
  summary["success_5m"] = share(mapped.within_5m, mapped.starts);
  summary["outside"] = tally.outside;
  summary["outside_false"] = tally.outside_false;
}

void add_answers(nlohmann::ordered_json& summary, const AllAnswers& answers, std::size_t starts) {
  summary["answers_judged"] = answers.judged;
  summary["wrong_answers"] = answers.wrong;
  summary["starts_with_wrong_answer"] = answers.starts_with_wrong;
  summary["wrong_interval"] = interval(answers.starts_with_wrong, starts);
  summary["wrong_later"] = answers.wrong_later;
  summary["wrong_withdrawn"] = {{"within_3m", answers.withdrawn_in_time},
                                {"later_or_never", answers.withdrawn_late},
                                {"undecided", answers.undecided},
                                {"longest_m", quantiles(answers.longest_wrong_m, 0.95, "p95")}};
  summary["reliability"] = {{"searches", reliability_json(answers.searches)},
                            {"localized", reliability_json(answers.localized)}};
}

nlohmann::ordered_json wrong_answer_json(const StartRecord& record) {
  const JudgedAnswer& wrong = *record.first_wrong;
  return {{"driven", wrong.distance_traveled_m},
          {"err", {wrong.error.m, wrong.error.rad * kDegreesPerRadian}},
          {"confidence", wrong.confidence},
          {"nees", wrong.nees},
          {"pose", pose_array(wrong.pose)},
          {"truth", pose_array(wrong.reference)},
          {"withdrawal", to_string(record.withdrawal)},
          {"longest_wrong_m", record.longest_wrong_m}};
}

/// A column per class of hits and of misses, by the names that core gives them.
void write_sample_header(std::ostream& csv) {
  EvidenceScore one_of_each;
  one_of_each.end_counts.fill(1);
  one_of_each.pass_counts.fill(1);
  csv << "log,start,distance_m,near_m,right,has_margin";
  for (const char* pose : {"best", "second"}) {
    for (const EvidenceClass& hits : hits_by_class(one_of_each))
      csv << ',' << pose << "_hits_" << hits.name;
    for (const EvidenceClass& misses : misses_by_class(one_of_each))
      csv << ',' << pose << "_misses_" << misses.name;
    csv << ',' << pose << "_matched";
  }
  csv << ",explained_share,independent_hits,significance,margin_per_hit,rival_evidence,"
         "unknown_share\n";
}

/// Whether the margin alone would let the pose be accepted.
bool has_least_margin(const DecisionSample& sample) {
  const AcceptanceParams limits;
  const double margin_per_hit = sample.terms.margin_per_hit;
  return margin_per_hit >= limits.min_mean_gap &&
         margin_per_hit * sample.best.ends >= limits.min_gap;
}

}  // namespace

nlohmann::ordered_json summary_json(const std::string& log_name, const Evaluation& evaluation,
                                    const EvaluationOptions& options) {
  const Tally tally = tally_of(evaluation.records, options.near_m);
  const AllScans& scans = tally.scans;
  nlohmann::ordered_json summary{{"log", log_name},
                                 {"split", evaluation.split},
                                 {"map_scans", evaluation.mapping_positions.size()},
                                 {"map_seconds", evaluation.map_seconds},
                                 {"features", evaluation.map->features().size()}};
  add_starts(summary, tally);
  add_answers(summary, tally.answers, tally.mapped.starts + tally.outside);
  summary["way_m"] = quantiles(tally.mapped.distances_m, 0.9, "p90");
  summary["seconds"] = quantiles(tally.mapped.seconds, 0.9, "p90");
  summary["error_m"] = quantiles(tally.mapped.errors_m, 0.95, "p95");
  summary["error_deg"] = quantiles(tally.mapped.errors_deg, 0.95, "p95");
  summary["tracked_right"] = share(scans.right_after, scans.right_after + scans.wrong_after);
  summary["nees"] = quantiles(scans.nees, 0.95, "p95");
  summary["server_ms_per_scan"] = costs(scans.ms());
  summary["searching_ms_per_scan"] = costs(scans.searching);
  summary["tracking_ms_per_scan"] = costs(scans.tracking);
  summary["rtt_ms_per_scan"] = quantiles(scans.round_trips, 0.95, "p95");
  summary["scans"] = scans.scans;
  summary["wall_s"] = std::round(10.0 * evaluation.wall_s) / 10.0;
  return summary;
}

nlohmann::ordered_json record_json(const StartRecord& record) {
  std::vector<double> ms = record.searching_ms;
  ms.insert(ms.end(), record.tracking_ms.begin(), record.tracking_ms.end());
  nlohmann::ordered_json json{
      {"start", record.start},
      {"near", record.near_m},
      {"result", to_string(record.verdict)},
      {"way", or_null(record.localized_after_m)},
      {"seconds", or_null(record.localized_after_s)},
      {"scans", record.scans},
      {"ms", std::move(ms)},
      {"rtt_ms", record.round_trip_ms},
      {"wrong_after", record.wrong_after},
      {"right_after", record.right_after},
      {"counts", record.counts},
      {"answers_judged", record.answers_judged},
      {"wrong_answers", record.wrong_answers},
      {"err", nlohmann::ordered_json::array()},
      {"driven", record.distance_traveled_m},
  };
  if (record.first_wrong) json["first_wrong"] = wrong_answer_json(record);
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

nlohmann::ordered_json report_score_json(const ReportScore& score) {
  return {{"places", score.simulated_places},
          {"success", score.success},
          {"starts", score.starts},
          {"squares", score.squares},
          {"rank_correlation",
           {{"starts", score.over_starts},
            {"squares", score.over_squares},
            {"at_the_starts", score.at_the_starts}}}};
}

void write_records(std::ostream& csv, const std::vector<StartRecord>& records) {
  csv << "start,near_m,verdict,way_m,seconds,driven_m,confidence,error_m,error_rad,x,y,yaw,true_x,"
         "true_y,true_yaw,scans,right_after,wrong_after,"
         "reason,answers_judged,wrong_answers,longest_wrong_m\n";
  for (const StartRecord& record : records) {
    csv << record.start << ',' << record.near_m << ',' << to_string(record.verdict) << ',';
    if (record.localized_after_m) csv << *record.localized_after_m;
    csv << ',';
    if (record.localized_after_s) csv << *record.localized_after_s;
    csv << ',' << record.distance_traveled_m << ',' << record.confidence << ',' << record.error_m
        << ',' << record.error_rad;
    for (const Pose2& pose : {record.pose, record.truth})
      csv << ',' << pose.x << ',' << pose.y << ',' << pose.yaw;
    csv << ',' << record.scans << ',' << record.right_after << ',' << record.wrong_after << ','
        << (record.verdict == Verdict::kNone ? to_string(record.reason) : "") << ','
        << record.answers_judged << ',' << record.wrong_answers << ',' << record.longest_wrong_m
        << '\n';
  }
}

void write_samples(std::ostream& csv, const std::string& name,
                   const std::vector<StartRecord>& records, bool header) {
  if (header) write_sample_header(csv);
  for (const StartRecord& record : records) {
    for (const DecisionSample& sample : record.samples) {
      csv << name << ',' << record.start << ',' << sample.distance_traveled_m << ','
          << sample.near_m << ',' << sample.right << ',' << has_least_margin(sample);
      for (const EvidenceScore* score : {&sample.best, &sample.second}) {
        for (const int count : score->end_counts) csv << ',' << count;
        for (const int count : score->pass_counts) csv << ',' << count;
        csv << ',' << score->matched;
      }
      const AcceptanceTerms& terms = sample.terms;
      for (const double term : {terms.explained_share, terms.independent_hits, terms.significance,
                                terms.margin_per_hit, terms.rival_evidence, terms.unknown_share})
        csv << ',' << term;
      csv << '\n';
    }
  }
}

}  // namespace cornerfix::evaluation
