/// \file  Lidar scans of a scene of walls, with seeded range noise.
#pragma once

#include <cstddef>
#include <limits>
#include <numbers>
#include <random>

#include <cornerfix/laser_scan.hpp>

#include "support/scene_builder.hpp"

namespace cornerfix::testing {

struct Lidar {
  std::size_t beams = 1440;
  double field_of_view_rad = 2.0 * std::numbers::pi;
  double range_max_m = 30.0;
  double noise_m = 0.0;  ///< Standard deviation of a range.
};

/// The scan taken at `T_map_laser`. The bearings are centred on the x axis, so a full turn has its
/// seam at pi. A beam that hits nothing is NaN.
[[nodiscard]] inline LaserScan simulate_scan(const SceneBuilder& scene, const Lidar& lidar,
                                             const Pose2& T_map_laser, std::mt19937_64& random) {
  LaserScan scan;
  scan.angle_min = -lidar.field_of_view_rad / 2.0;
  scan.angle_increment = lidar.field_of_view_rad / static_cast<double>(lidar.beams);
  scan.range_min = 0.05;
  scan.range_max = lidar.range_max_m;
  scan.ranges.reserve(lidar.beams);
  std::normal_distribution<double> noise(0.0, 1.0);
  for (std::size_t beam = 0; beam < lidar.beams; ++beam) {
    const double range =
        scene.range(T_map_laser.translation(), T_map_laser.yaw + scan.bearing(beam));
    const double measured = range + lidar.noise_m * noise(random);
    scan.ranges.push_back(range <= lidar.range_max_m ? static_cast<float>(measured)
                                                     : std::numeric_limits<float>::quiet_NaN());
  }
  return scan;
}

/// Without noise.
[[nodiscard]] inline LaserScan simulate_scan(const SceneBuilder& scene, Lidar lidar,
                                             const Pose2& T_map_laser) {
  lidar.noise_m = 0.0;
  std::mt19937_64 unused(0);
  return simulate_scan(scene, lidar, T_map_laser, unused);
}

}  // namespace cornerfix::testing
