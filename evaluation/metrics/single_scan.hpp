/// \file  The single-scan protocol of CBGL (Filotheou 2024): one scan, no odometry, the answer
/// forced.
///
/// The best pose of the first search counts, accepted or not. It is correct within 0.5 m; its
/// heading is reported apart. Beside it stand the poses that the localizer would have accepted.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "evaluation/metrics/localization_score.hpp"
#include "evaluation/metrics/pose_error.hpp"

namespace cornerfix::evaluation {

/// One robot that has one scan.
struct SingleScanRecord {
  std::size_t scan = 0;       ///< Index in the log.
  double near_m = 0.0;        ///< From the nearest mapping pose.
  bool accepted = false;      ///< Whether the answer was `localized`.
  bool in_right_map = false;  ///< Of the best pose.
  double confidence = 0.0;
  std::optional<PoseError> error;  ///< Of the best pose; nothing without a pose.
  double ms = 0.0;                 ///< Processor time.

  /// Within 0.5 m; the heading does not matter.
  [[nodiscard]] bool is_right() const {
    return in_right_map && error && error->m <= kCorrectDistance;
  }
  [[nodiscard]] bool has_right_heading() const { return is_right() && error->rad <= kCorrectAngle; }
};

/// Asks scans spread evenly over `asking`. Logs with keyframes are asked at keyframes, where their
/// references are exact. The parameters are those of evaluate().
[[nodiscard]] std::vector<SingleScanRecord> evaluate_single_scans(
    const RecordedLog& log, std::span<const std::size_t> asking,
    const std::vector<LocalizationMapPtr>& maps, std::size_t right_map,
    const std::vector<Point2>& mapping_positions, const EvaluationOptions& options,
    const ShareDone& progress);

[[nodiscard]] nlohmann::ordered_json single_scan_summary_json(
    const std::string& log_name, const std::vector<SingleScanRecord>& records, double near_m);

[[nodiscard]] nlohmann::ordered_json single_scan_record_json(const SingleScanRecord& record);

}  // namespace cornerfix::evaluation
