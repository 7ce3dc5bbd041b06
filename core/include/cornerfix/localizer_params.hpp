/// \file  All settings of a localizer in one struct, with one struct per stage, and the region in
/// which a robot may start: a dock, a zone, the last known pose.
#pragma once

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include <cornerfix/corners.hpp>
#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// Where hypotheses come from. Names on the wire: to_string().
enum class Method {
  kIndexed,  ///< Corners, triangles of them, and all places of the map by branch and bound.
  kRma,      ///< The paper's random match.
  kNma,      ///< The paper's naive match: every local against every global descriptor.
};

[[nodiscard]] std::string_view to_string(Method method);
[[nodiscard]] std::optional<Method> method_from_string(std::string_view name);

/// Of the random match (rma): p and N / N_local of eq. (18).
struct SampledMatchParams {
  double success_probability = 0.95;  ///< p; in (0, 1).
  double overlap = 0.5;               ///< N / N_local expected; in (0, 1].
  std::uint64_t seed = 1;             ///< Same seed and input give the same draws.
};

[[nodiscard]] std::optional<Error> validate(const SampledMatchParams& params);

/// Limits of the consensus search of rma and nma (docs/method/11-parameters.md).
struct PoseEstimatorParams {
  double inlier_distance_m = 0.30;  ///< Largest residual of an inlier; > 0.
  int min_inliers = 4;              ///< Fewer than this is no pose; >= 2.
  int max_iterations = 100;         ///< Sampled pairs at most; >= 1.
  std::uint64_t seed = 1;           ///< Same seed and input give the same answer.
};

[[nodiscard]] std::optional<Error> validate(const PoseEstimatorParams& params);

/// When a candidate pose is accepted.
struct AcceptanceParams {
  double min_probability = 0.998;  ///< Of the calibrated model; in (0, 1).
  double min_gap = 3.0;        ///< Log-likelihood less that of the best other place [nat]; >= 0.
  double min_mean_gap = 0.02;  ///< The same a hit: identical rooms stay below; >= 0.
};

/// Of the paper's methods, kRma and kNma; kIndexed uses none of them.
struct PaperParams {
  int min_features = 4;         ///< Submap features before matching is tried; >= 3.
  int min_votes = 4;            ///< S_t of algorithm 3; >= 1.
  int max_matches = 8;          ///< Matches tried as hypotheses per scan; in [1, 1000].
  SampledMatchParams sampling;  ///< Of kRma; its seed is drawn from that of LocalizerParams.
  PoseEstimatorParams estimator;
};

/// docs/method/11-parameters.md has the source of each default.
struct LocalizerParams {
  Method method = Method::kIndexed;
  CornerExtractor extractor =
      CornerExtractor::kLineIntersection;  ///< That of the maps, for good matches.
  std::uint64_t seed = 1;                  ///< Of all random draws.
  /// Work of one scan in judging candidates and in searches of whole maps, as time of one core on
  /// the machine of docs/results.md [ms]; > 0. It counts operations, so answers do not depend on
  /// the clock. A longer search continues at the next scans.
  double search_budget_ms = 40.0;
  AcceptanceParams acceptance;
  PaperParams paper;
};

/// `field` of an error is the name on the wire, where the members of `paper` stand beside the
/// others.
[[nodiscard]] std::optional<Error> validate(const LocalizerParams& params);

/// Poses that base_link may have at the first scan after Localizer::reset(). Poses outside are not
/// searched, also not as rivals, so the probability of an answer is conditional on the region.
struct StartRegion {
  std::string map{};                            ///< Name; empty: any of the localizer's maps.
  Point2 center = Point2::Zero();               ///< In `map` [m].
  double radius_m = 0.0;                        ///< > 0
  std::optional<double> yaw{};                  ///< In `map` [rad]; any when not given.
  double yaw_tolerance_rad = std::numbers::pi;  ///< To both sides of yaw; in (0, pi].

  friend bool operator==(const StartRegion&, const StartRegion&) = default;
};

[[nodiscard]] std::optional<Error> validate(const StartRegion& region);

}  // namespace cornerfix
