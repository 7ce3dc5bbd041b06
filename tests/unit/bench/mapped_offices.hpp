/// \file  The offices of the tests with what rivals want of them, made once.
#pragma once

#include <vector>

#include "bench/rivals/robot_motion.hpp"
#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"

namespace cornerfix::bench::testing {

inline const std::vector<PosedScan>& office_scans() {
  static const auto scans =
      cornerfix::testing::mapping_scans(cornerfix::testing::offices(), {1.0, 1.0});
  return scans;
}

inline const LocalizationMapPtr& office_map() {
  static const auto map = std::make_shared<const LocalizationMap>(
      "offices", 1, cornerfix::testing::map_content(office_scans()));
  return map;
}

/// A run into two of the offices with a scan every 0.2 m and good odometry.
inline std::vector<cornerfix::testing::Moment> office_drive(std::uint64_t seed) {
  return cornerfix::testing::drive(cornerfix::testing::offices(), {},
                                   cornerfix::testing::drive_through_offices(0.2, 0.2), seed);
}

/// The ends of the beams that a lidar there sees, in base_link.
inline std::vector<Point2> ends_seen(const Pose2& T_map_base_link) {
  const cornerfix::testing::Lidar lidar{.beams = 360};
  return ends_in_base_link(
      {cornerfix::testing::simulate_scan(cornerfix::testing::offices(), lidar, T_map_base_link),
       {},
       std::nullopt});
}

}  // namespace cornerfix::bench::testing
