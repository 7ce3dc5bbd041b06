#include "evaluation/metrics/slam_report.hpp"

#include <span>
#include <vector>

#include "evaluation/metrics/degrees.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/metrics/revisit_score.hpp"
#include "evaluation/metrics/trajectory_score.hpp"

namespace cornerfix::evaluation {

namespace {

/// Each value times `factor`.
nlohmann::ordered_json spread(const std::vector<double>& values, double factor) {
  const auto at = [&](double share) {
    return to_four_decimals(factor * percentile(values, share));
  };
  return {{"mean", to_four_decimals(factor * mean(values))},
          {"p50", at(0.5)},
          {"p95", at(0.95)},
          {"max", at(1.0)}};
}

nlohmann::ordered_json spreads(const RelativePoseError& error) {
  return {{"error_m", spread(error.errors_m, 1.0)},
          {"error_deg", spread(error.errors_rad, kDegreesPerRadian)}};
}

nlohmann::ordered_json relative_error_json(const RelativePoseError& error) {
  nlohmann::ordered_json json = {{"way_m", error.path_length_m},
                                 {"relations", error.errors_m.size()}};
  json.update(spreads(error));
  return json;
}

/// The errors of the trajectory, and of the log's reference, over pairs of scans of one place.
nlohmann::ordered_json revisits_json(std::span<const LogScan> scans, const SlamRun& run) {
  std::vector<std::size_t> indices = reference_scans(scans);
  std::vector<std::vector<Pose2>> trajectories = {run.T_map_laser};
  if (indices.empty()) {
    indices = run.key_scans;
  } else {
    trajectories.emplace_back();
    for (const LogScan& scan : scans)
      trajectories.back().push_back(scan.T_map_laser.value_or(Pose2{}));
  }
  const RevisitScore score = score_revisits(scans, indices, trajectories);
  nlohmann::ordered_json json = {{"pairs", score.pairs}, {"undecided", score.undecided}};
  if (score.pairs == 0) return json;
  json["found"] = spreads(score.errors.front());
  if (score.errors.size() > 1) json["reference"] = spreads(score.errors.back());
  return json;
}

}  // namespace

nlohmann::ordered_json slam_report_json(const RecordedLog& log, const SlamRun& run,
                                        double cpu_seconds) {
  nlohmann::ordered_json report = {{"log", log.header.name},
                                   {"scans", log.scans.size()},
                                   {"keyframes", run.key_scans.size()},
                                   {"submaps", run.submaps},
                                   {"loop_closures", run.loop_closures},
                                   {"cpu_seconds", to_four_decimals(cpu_seconds)}};
  for (const double path_length_m : {2.0, 20.0}) {
    const RelativePoseError error = relative_pose_error(log.scans, run.T_map_laser, path_length_m);
    if (!error.errors_m.empty())
      report["relative_pose_error"].push_back(relative_error_json(error));
  }
  report["revisits"] = revisits_json(log.scans, run);
  return report;
}

}  // namespace cornerfix::evaluation
