#include "core/src/slam/loop_closer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include <cornerfix/localizer_params.hpp>

#include "core/src/acceptance/acceptance.hpp"
#include "core/src/base/thinned.hpp"
#include "core/src/matching/scan_refiner.hpp"
#include "core/src/search/same_place.hpp"

namespace cornerfix {
namespace {

constexpr double kLoopRivalMargin = 0.5;  // mean log-likelihood below the best that is looked at
// Margin over every other pose, per hit [nat]. A wrong loop bends the map for good, while later
// scans withdraw a wrong pose of a robot.
constexpr double kLoopMargin = 0.17;

// Of points on a submap's walls.
constexpr double kMinInlierShare = 0.55;
constexpr double kMaxShift = 0.5;      // from where they were believed to lie [m]
constexpr double kMaxTurn = 0.12;      // [rad]
constexpr double kLeastSigmaM = 0.02;  // what the submap itself may be bent by
constexpr double kLeastSigmaRad = 0.005;

struct LoopCandidate {
  Pose2 T_map_submap;
  EvidenceScore score;
};

/// Refined and scored, each place once, best first.
std::vector<LoopCandidate> candidates_in(const SubmapMosaic& mosaic, const DriveSubmap& submap,
                                         const Pose2& T_map_submap_predicted) {
  std::vector<Pose2> starts{T_map_submap_predicted};
  for (const Place& place : mosaic.place_search().find(submap.evidence.ends, thinned(submap.way, 8),
                                                       {.max_mean_gap = kLoopRivalMargin}))
    starts.push_back(place.T_map_base_link);
  std::vector<LoopCandidate> all;
  for (const Pose2& start : starts) {
    const Pose2 T = refined_coarse_to_fine(mosaic.field(), submap.evidence.ends, start);
    all.push_back({T, score_evidence(mosaic.classes(), submap.evidence, T)});
  }
  std::ranges::stable_sort(all, std::ranges::greater{},
                           [](const LoopCandidate& one) { return one.score.fit; });
  std::vector<LoopCandidate> distinct;
  for (const LoopCandidate& one : all) {
    const bool known = std::ranges::any_of(distinct, [&](const LoopCandidate& other) {
      return is_same_place(one.T_map_submap, other.T_map_submap);
    });
    if (!known) distinct.push_back(one);
  }
  return distinct;
}

/// Whether the first of `places` explains what was seen, and better than all others.
bool is_certain(std::span<const LoopCandidate> places, double free_area_m2) {
  if (places.empty() || places.front().score.ends == 0) return false;
  const EvidenceScore& best = places.front().score;
  double margin =
      std::min(best.log_likelihood - kMinPlaceWeight * best.ends, kLoopRivalMargin * best.ends);
  std::vector<double> log_odds;
  for (const LoopCandidate& rival : places.subspan(1)) {
    margin = std::min(margin, best.log_likelihood - rival.score.log_likelihood);
    log_odds.push_back(rival_log_odds(best, rival.score));
  }
  const AcceptanceParams acceptance;
  const AcceptanceTerms terms = weigh(best, margin, log_odds, free_area_m2);
  return margin >= kLoopMargin * best.ends && margin >= acceptance.min_gap &&
         terms.probability_correct >= acceptance.min_probability;
}

}  // namespace

std::optional<FoundPlace> find_place(const DriveSubmap& submap, const SubmapMosaic& mosaic,
                                     const Pose2& T_map_submap_predicted, const DriftBound& drift) {
  const std::vector<LoopCandidate> all = candidates_in(mosaic, submap, T_map_submap_predicted);
  std::vector<LoopCandidate> near;
  std::ranges::copy_if(all, std::back_inserter(near), [&](const LoopCandidate& one) {
    return distance(one.T_map_submap, T_map_submap_predicted) <= drift.position_m &&
           angle_between(one.T_map_submap, T_map_submap_predicted) <= drift.yaw_rad;
  });
  const double near_area_m2 = std::numbers::pi * drift.position_m * drift.position_m;
  if (is_certain(near, near_area_m2)) return FoundPlace{near.front().T_map_submap, true};
  if (is_certain(all, mosaic.free_area_m2())) return FoundPlace{all.front().T_map_submap, false};
  return std::nullopt;
}

std::optional<PoseRelation> relate(std::span<const Point2> points_from, const DriveSubmap& submap,
                                   const Pose2& T_submap_from) {
  const PosePrior prior = isotropic_prior(T_submap_from, 0.3, 0.1);
  const Pose2 coarse = aligned_pose(submap.field, points_from, T_submap_from,
                                    {.kernel_m = 0.3, .max_iterations = 6}, prior);
  const ScanRefinerParams finely{.kernel_m = 0.1, .max_iterations = 8};
  const RefinedPose fine = refine_pose(submap.field, points_from, coarse, finely, prior);
  if (fine.inlier_share < kMinInlierShare ||
      distance(fine.T_frame_base_link, T_submap_from) > kMaxShift ||
      angle_between(fine.T_frame_base_link, T_submap_from) > kMaxTurn)
    return std::nullopt;
  Eigen::Matrix3d shown =
      observed_information(submap.field, points_from, fine.T_frame_base_link, finely);
  shown.diagonal() += Eigen::Vector3d{1.0, 1.0, 10.0};  // blind directions: a metre, a third of rad
  Eigen::Matrix3d covariance = shown.inverse();
  covariance.diagonal() += Eigen::Vector3d{kLeastSigmaM * kLeastSigmaM, kLeastSigmaM * kLeastSigmaM,
                                           kLeastSigmaRad * kLeastSigmaRad};
  return PoseRelation{.T_from_to = fine.T_frame_base_link,
                      .information = covariance.inverse(),
                      .may_be_wrong = true};
}

}  // namespace cornerfix
