/// \file  Why a robot took a pose, or none: what the decision saw of the best pose and its rival.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include <cornerfix/localizer.hpp>

#include "evaluation/metrics/localization_score.hpp"
#include "evaluation/metrics/png_image.hpp"

namespace cornerfix::evaluation {

/// The search at which a robot became localized, or the last one if it never did.
struct Decision {
  std::size_t scan = 0;                 ///< Index in the log.
  Answer answer;                        ///< What the robot was given.
  std::vector<RankedHypothesis> poses;  ///< All that the search found, best first.
  std::vector<SubmapScanPtr> submap;    ///< What the robot had seen.
  Pose2 T_submap_base_link;
  Pose2 reference;
};

struct Explanation {
  StartRecord record;
  std::optional<Decision> decision;  ///< Nothing when the whole map was never searched.
};

/// Runs one robot from the scan `start` of the log as evaluate() does. A second localizer that
/// accepts nothing goes beside it, since an answer with a pose no longer lists the rivals.
/// `asking` holds `start`.
[[nodiscard]] Explanation explain(const RecordedLog& log, std::span<const std::size_t> asking,
                                  std::size_t start, const std::vector<LocalizationMapPtr>& maps,
                                  std::size_t right_map,
                                  const std::vector<Point2>& mapping_positions,
                                  const EvaluationOptions& options);

/// Poses with their hits by class, the contribution of each class and the terms of the probability.
[[nodiscard]] nlohmann::ordered_json explanation_json(const Explanation& explanation,
                                                      const LocalizationMap* right_map);

/// Side by side: the scans of the submap laid on the map at the best pose, at the rival and at the
/// reference. Hits are red, the robot is blue.
[[nodiscard]] PngImage draw_decision(const Decision& decision, const LocalizationMap* right_map);

}  // namespace cornerfix::evaluation
