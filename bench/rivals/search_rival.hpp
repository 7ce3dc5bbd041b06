/// \file  A rival that finds the robot by one scan and then follows it by scan matching.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "bench/rivals/rival.hpp"
#include "bench/rivals/robot_motion.hpp"
#include "core/src/map/distance_field.hpp"

namespace cornerfix::bench {

/// Where a single scan with these hits in base_link was taken.
using ScanSearch = std::function<std::optional<Pose2>(std::span<const Point2>)>;

/// Follows a robot from a known pose: Gauss-Newton on the distance to the walls, from where
/// odometry says that it went.
class ScanFollower {
 public:
  /// `field` must outlive the follower.
  ScanFollower(const DistanceField& field, const Pose2& T_map_base_link);

  [[nodiscard]] Pose2 follow(const Pose2& motion, std::span<const Point2> ends_base_link);

 private:
  const DistanceField* field_;
  Pose2 T_map_base_link_;
};

/// Searches at the first scan and after every 0.2 m or 10 deg, until the search finds a place,
/// which is then believed.
class SearchRival : public Rival {
 public:
  SearchRival(ScanSearch search, const DistanceField& field);

  [[nodiscard]] RivalAnswer process(const RobotScan& scan) override;
  [[nodiscard]] std::size_t bytes() const override { return sizeof(*this); }

 private:
  ScanSearch search_;
  const DistanceField& field_;
  MotionFilter filter_{0.2, 0.175};
  std::optional<Pose2> last_T_odom_base_link_;
  std::optional<ScanFollower> follower_;
};

}  // namespace cornerfix::bench
