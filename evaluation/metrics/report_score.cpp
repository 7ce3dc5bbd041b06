#include "evaluation/metrics/report_score.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace cornerfix::evaluation {

namespace {

constexpr double kSquare = 2.0;  // [m]
constexpr std::size_t kMinStarts = 3;
constexpr double kAngleSpread = 0.25 * std::numbers::pi;

std::vector<double> ranks_of(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return values[i]; });
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    for (std::size_t k = begin; k < end; ++k)
      ranks[order[k]] = 0.5 * static_cast<double>(begin + end - 1);
    begin = end;
  }
  return ranks;
}

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(std::max<std::size_t>(1, values.size()));
}

/// Predicted and measured path lengths of starts.
struct PathLengths {
  std::vector<double> predicted_m;
  std::vector<double> driven_m;

  void add(double predicted, double driven) {
    predicted_m.push_back(predicted);
    driven_m.push_back(driven);
  }
  [[nodiscard]] double correlation() const { return rank_correlation(predicted_m, driven_m); }
};

PathLengths means_in_squares(const std::map<std::pair<int, int>, PathLengths>& squares) {
  PathLengths means;
  for (const auto& [square, lengths] : squares) {
    if (lengths.predicted_m.size() < kMinStarts) continue;
    means.add(mean_of(lengths.predicted_m), mean_of(lengths.driven_m));
  }
  return means;
}

}  // namespace

double rank_correlation(std::span<const double> a, std::span<const double> b) {
  const std::vector<double> ranks_a = ranks_of(a);
  const std::vector<double> ranks_b = ranks_of(b);
  const double mean = 0.5 * (static_cast<double>(a.size()) - 1.0);
  double product = 0.0;
  double square_a = 0.0;
  double square_b = 0.0;
  for (std::size_t i = 0; i < ranks_a.size(); ++i) {
    product += (ranks_a[i] - mean) * (ranks_b[i] - mean);
    square_a += (ranks_a[i] - mean) * (ranks_a[i] - mean);
    square_b += (ranks_b[i] - mean) * (ranks_b[i] - mean);
  }
  return square_a > 0.0 && square_b > 0.0 ? product / std::sqrt(square_a * square_b) : 0.0;
}

double predicted_distance_m(const LocalizabilityReport& report, const Pose2& T_map_start) {
  constexpr double kLeastWeight = 1e-300;  // where all starts are far away, all count
  double sum = 0.0;
  double weights = 0.0;
  for (const AssessedPlace& place : report.places) {
    for (const AssessedStart& start : place.starts) {
      const double m = distance(start.T_map_base_link, T_map_start) / (0.5 * report.lattice_m);
      const double rad = angle_between(start.T_map_base_link, T_map_start) / kAngleSpread;
      const double weight = std::exp(-0.5 * (m * m + rad * rad)) + kLeastWeight;
      sum += weight * start.way_m.value_or(report.way_limit_m);
      weights += weight;
    }
  }
  return weights > 0.0 ? sum / weights : report.way_limit_m;
}

ReportScore score_report(const RecordedLog& log, const Evaluation& evaluation,
                         const EvaluationOptions& options) {
  LocalizabilityParams params;
  params.way_m = options.max_distance_m;
  params.robot.lidar = log.scans.front().scan;
  params.robot.beams = log.scans.front().scan.ranges.size();
  const LocalizabilityReport report =
      assess_localizability(evaluation.map, params).value_or(LocalizabilityReport{});

  ReportScore score;
  score.simulated_places = report.places.size();
  double found = 0.0;
  double simulated = 0.0;
  for (const AssessedPlace& place : report.places) {
    for (const AssessedStart& start : place.starts) {
      found += start.way_m ? 1.0 : 0.0;
      simulated += 1.0;
    }
  }
  score.success = found / std::max(1.0, simulated);
  PathLengths starts;
  std::vector<Pose2> T_map_starts;
  std::map<std::pair<int, int>, PathLengths> squares;
  for (const StartRecord& record : evaluation.records) {
    if (!record.counts || record.near_m > options.near_m) continue;
    const Pose2& T_map_start = *log.scans[record.start].T_map_laser;
    const double driven = record.verdict == Verdict::kCorrect
                              ? record.localized_after_m.value_or(params.way_m)
                              : params.way_m;
    const double predicted = predicted_distance_m(report, T_map_start);
    starts.add(predicted, driven);
    squares[{static_cast<int>(std::floor(T_map_start.x / kSquare)),
             static_cast<int>(std::floor(T_map_start.y / kSquare))}]
        .add(predicted, driven);
    T_map_starts.push_back(T_map_start);
  }
  const std::vector<AssessedStart> simulated_starts =
      assess_starts(evaluation.map, T_map_starts, params);
  PathLengths same_starts;
  for (std::size_t i = 0; i < simulated_starts.size(); ++i)
    same_starts.add(simulated_starts[i].way_m.value_or(params.way_m), starts.driven_m[i]);
  const PathLengths means = means_in_squares(squares);
  score.starts = starts.predicted_m.size();
  score.squares = means.predicted_m.size();
  score.over_starts = starts.correlation();
  score.over_squares = means.correlation();
  score.at_the_starts = same_starts.correlation();
  return score;
}

}  // namespace cornerfix::evaluation
