#include "loop_closer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include <cornerfix/localizer_params.hpp>
#include <cornerfix/scan_refiner.hpp>

#include "thinned.hpp"

namespace cornerfix {
namespace {

constexpr double kDistinctDistance = 1.0;  // places nearer than this and
constexpr double kDistinctAngle = 0.26;    // turned by less than this are one
constexpr double kRivalMargin = 0.5;       // mean log-likelihood below the best that is looked at
constexpr double kMinRivalWeight = -0.5;   // below this a place is none [nat]
constexpr std::size_t kRefinePoints = 200;

// Of points on a submap's walls.
constexpr double kMinInlierShare = 0.55;
constexpr double kMaxShift = 0.5;      // from where they were believed to lie [m]
constexpr double kMaxTurn = 0.12;      // [rad]
constexpr double kLeastSigmaM = 0.02;  // what the submap itself may be bent by
constexpr double kLeastSigmaRad = 0.005;

struct Candidate {
  Pose2 T_map_submap;
  EvidenceScore score;
};

Pose2 refined(const SubmapMosaic& mosaic, std::span<const Point2> points, Pose2 T_map_submap) {
  for (const double kernel_m : {0.4, 0.1}) {
    T_map_submap = refine_pose(mosaic.field(), points, T_map_submap,
                               {.kernel_m = kernel_m, .max_iterations = 8})
                       .T_frame_base_link;
  }
  return T_map_submap;
}

bool is_same_place(const Pose2& a, const Pose2& b) {
  return distance(a, b) < kDistinctDistance && angle_between(a, b) < kDistinctAngle;
}

/// Refined and scored, each place once, best first.
std::vector<Candidate> candidates_in(const SubmapMosaic& mosaic, const DriveSubmap& submap,
                                     const Pose2& T_map_submap_predicted) {
  std::vector<Pose2> starts{T_map_submap_predicted};
  for (const Place& place : mosaic.place_search().find(submap.evidence.ends, thinned(submap.way, 8),
                                                       {.max_mean_gap = kRivalMargin}))
    starts.push_back(place.T_map_base_link);
  const std::vector<Point2> points = thinned(submap.evidence.ends, kRefinePoints);
  std::vector<Candidate> all;
  for (const Pose2& start : starts) {
    const Pose2 T = refined(mosaic, points, start);
    all.push_back({T, score_evidence(mosaic.classes(), submap.evidence, T)});
  }
  std::ranges::stable_sort(all, std::ranges::greater{},
                           [](const Candidate& one) { return one.score.fit; });
  std::vector<Candidate> distinct;
  for (const Candidate& one : all) {
    const bool known = std::ranges::any_of(distinct, [&](const Candidate& other) {
      return is_same_place(one.T_map_submap, other.T_map_submap);
    });
    if (!known) distinct.push_back(one);
  }
  return distinct;
}

/// Whether the first of `places` explains what was seen, and better than all others.
bool is_certain(std::span<const Candidate> places) {
  if (places.empty() || places.front().score.ends == 0) return false;
  const EvidenceScore& best = places.front().score;
  double gap =
      std::min(best.log_likelihood - kMinRivalWeight * best.ends, kRivalMargin * best.ends);
  for (const Candidate& rival : places.subspan(1))
    gap = std::min(gap, best.log_likelihood - rival.score.log_likelihood);
  const AcceptanceParams acceptance;
  return gap >= acceptance.min_mean_gap * best.ends && gap >= acceptance.min_gap &&
         probability_right(best, gap) >= acceptance.min_probability;
}

}  // namespace

std::optional<FoundPlace> find_place(const DriveSubmap& submap, const SubmapMosaic& mosaic,
                                     const Pose2& T_map_submap_predicted, const DriftBound& drift) {
  const std::vector<Candidate> all = candidates_in(mosaic, submap, T_map_submap_predicted);
  std::vector<Candidate> near;
  std::ranges::copy_if(all, std::back_inserter(near), [&](const Candidate& one) {
    return distance(one.T_map_submap, T_map_submap_predicted) <= drift.position_m &&
           angle_between(one.T_map_submap, T_map_submap_predicted) <= drift.yaw_rad;
  });
  if (is_certain(near)) return FoundPlace{near.front().T_map_submap, true};
  if (is_certain(all)) return FoundPlace{all.front().T_map_submap, false};
  return std::nullopt;
}

std::optional<PoseRelation> relate(std::span<const Point2> points_from, const DriveSubmap& submap,
                                   const Pose2& T_submap_from) {
  const PosePrior prior = isotropic_prior(T_submap_from, 0.3, 0.1);
  const RefinedPose coarse = refine_pose(submap.field, points_from, T_submap_from,
                                         {.kernel_m = 0.3, .max_iterations = 6}, prior);
  const RefinedPose fine = refine_pose(submap.field, points_from, coarse.T_frame_base_link,
                                       {.kernel_m = 0.1, .max_iterations = 8}, prior);
  if (fine.inlier_share < kMinInlierShare ||
      distance(fine.T_frame_base_link, T_submap_from) > kMaxShift ||
      angle_between(fine.T_frame_base_link, T_submap_from) > kMaxTurn)
    return std::nullopt;
  Eigen::Matrix3d shown = fine.information;
  shown.diagonal() += Eigen::Vector3d{1.0, 1.0, 10.0};  // blind directions: a metre, a third of rad
  Eigen::Matrix3d covariance = shown.inverse();
  covariance.diagonal() += Eigen::Vector3d{kLeastSigmaM * kLeastSigmaM, kLeastSigmaM * kLeastSigmaM,
                                           kLeastSigmaRad * kLeastSigmaRad};
  return PoseRelation{.T_from_to = fine.T_frame_base_link,
                      .information = covariance.inverse(),
                      .may_be_wrong = true};
}

}  // namespace cornerfix
