#include "bench/rivals/published_rma.hpp"

#include <utility>
#include <vector>

#include "bench/rivals/robot_motion.hpp"
#include "core/src/matching/scan_refiner.hpp"
#include "core/src/search/map_index.hpp"

namespace cornerfix::bench {

PublishedRma::PublishedRma(LocalizationMapPtr map, const PublishedRmaParams& params)
    : map_(std::move(map)), params_(params) {}

RivalAnswer PublishedRma::process(const RobotScan& scan) {
  const Pose2 motion = motion_between(last_T_odom_base_link_, scan.T_odom_base_link);
  last_T_odom_base_link_ = scan.T_odom_base_link;
  const std::vector<Point2> ends = ends_in_base_link(scan);
  if (follower_) return {follower_->follow(motion, ends), true};
  T_submap_base_link_ = match_submap(motion, ends);
  if (!submap_.wants(T_submap_base_link_, scan.T_base_link_laser)) return {};
  submap_.keep({0, scan.scan, scan.T_base_link_laser, T_submap_base_link_},
               extract_corners(scan.scan, CornerExtractor::kVfp));
  const std::optional<Pose2> T_map_submap = match_map();
  if (!T_map_submap) return {};
  const Pose2 initial = *T_map_submap * T_submap_base_link_;  // eq. (17)
  const Pose2 refined = refine_pose(map_->index().field, ends, initial, {}).T_frame_base_link;
  follower_.emplace(map_->index().field, refined);
  return {refined, true};
}

Pose2 PublishedRma::match_submap(const Pose2& motion, std::span<const Point2> ends) {
  const Pose2 predicted = T_submap_base_link_ * motion;
  if (submap_.empty()) return predicted;
  return submap_.match(ends, isotropic_prior(predicted, 0.05, 0.03)).T_frame_base_link;
}

/// Sections 3.2-3.4: the match with most votes (eqs. 14, 15, 18) and RANSAC over its pairs (eq.
/// 16).
std::optional<Pose2> PublishedRma::match_map() const {
  const std::vector<Feature>& features = submap_.features();
  const DescriptorIndex& global = map_->index().descriptor_index;
  const DescriptorSet local = describe(features, global.params());
  const auto matches = match_sampled(local, global, params_.min_votes, 1, params_.sampling);
  if (matches.empty()) return std::nullopt;
  const DescriptorMatch& best = matches.front();
  const auto theirs = describe_one(map_->features(), best.global_feature, global.params());
  std::vector<Correspondence> correspondences;
  for (const auto& [m, n] : pairs_of(best, local[best.local_feature], theirs, local.angle_bins())) {
    correspondences.push_back({features[m].position, map_->features()[n].position});
  }
  const auto estimate = estimate_pose(correspondences, params_.estimator);
  return estimate ? std::optional(estimate->T_map_submap) : std::nullopt;
}

}  // namespace cornerfix::bench
