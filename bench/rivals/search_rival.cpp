#include "bench/rivals/search_rival.hpp"

#include <utility>
#include <vector>

#include "core/src/matching/scan_refiner.hpp"

namespace cornerfix::bench {

ScanFollower::ScanFollower(const DistanceField& field, const Pose2& T_map_base_link)
    : field_(&field), T_map_base_link_(T_map_base_link) {}

Pose2 ScanFollower::follow(const Pose2& motion, std::span<const Point2> ends_base_link) {
  const Pose2 predicted = T_map_base_link_ * motion;
  T_map_base_link_ =
      refine_pose(*field_, ends_base_link, predicted, {}, isotropic_prior(predicted, 0.05, 0.03))
          .T_frame_base_link;
  return T_map_base_link_;
}

SearchRival::SearchRival(ScanSearch search, const DistanceField& field)
    : search_(std::move(search)), field_(field) {}

RivalAnswer SearchRival::process(const RobotScan& scan) {
  const Pose2 motion = motion_between(last_T_odom_base_link_, scan.T_odom_base_link);
  last_T_odom_base_link_ = scan.T_odom_base_link;
  if (!follower_ && !filter_.opens(scan.T_odom_base_link)) return {std::nullopt, false};
  const std::vector<Point2> ends = ends_in_base_link(scan);
  if (follower_) return {follower_->follow(motion, ends), true};
  const std::optional<Pose2> found = search_(ends);
  if (!found) return {std::nullopt, true};
  const Pose2 refined = refine_pose(field_, ends, *found, {}).T_frame_base_link;
  follower_.emplace(field_, refined);
  return {refined, true};
}

}  // namespace cornerfix::bench
