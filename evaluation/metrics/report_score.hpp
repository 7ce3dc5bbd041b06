/// \file  How well a map's localizability report predicts what the robots of a log needed there.
#pragma once

#include <cstddef>
#include <span>

#include <cornerfix/localizability.hpp>

#include "evaluation/metrics/localization_score.hpp"

namespace cornerfix::evaluation {

/// Rank correlations (Spearman) of the path length until localized, predicted and driven. A start
/// that is not localized correctly counts with the whole path allowed.
struct ReportScore {
  std::size_t simulated_places = 0;  ///< Of the report.
  double success = 0.0;              ///< That the report predicts.
  std::size_t starts = 0;            ///< Of the log, in the mapped part.
  std::size_t squares = 0;           ///< Of 2 m, with three of them or more.
  double over_starts = 0.0;
  double over_squares = 0.0;   ///< Of the means in each square.
  double at_the_starts = 0.0;  ///< Robots simulated at the very starts, not by the report.
};

/// Spearman's, equal values with their mean rank; 0 when either has no two different values. Both
/// of one length.
[[nodiscard]] double rank_correlation(std::span<const double> a, std::span<const double> b);

/// What a report predicts for a robot started anywhere: the mean of its starts. Weights fall with
/// half a spacing of the lattice and with half the angle between them.
[[nodiscard]] double predicted_distance_m(const LocalizabilityReport& report,
                                          const Pose2& T_map_start);

/// Robots are simulated with the lidar of the log's first scan.
[[nodiscard]] ReportScore score_report(const RecordedLog& log, const Evaluation& evaluation,
                                       const EvaluationOptions& options);

}  // namespace cornerfix::evaluation
