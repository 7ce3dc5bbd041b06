/// \file  Scans at known poses along a path through the offices.
#pragma once

#include <random>
#include <vector>

#include <cornerfix/laser_scan.hpp>

#include "support/floor_plans.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix::testing {

/// A scan of `scene` at each pose.
[[nodiscard]] inline std::vector<PosedScan> posed_scans(const SceneBuilder& scene,
                                                        const std::vector<Pose2>& poses,
                                                        std::uint64_t seed) {
  const Lidar lidar{.beams = 240, .noise_m = 0.01};
  std::mt19937_64 random(seed);
  std::vector<PosedScan> scans;
  for (const Pose2& pose : poses)
    scans.push_back({simulate_scan(scene, lidar, pose, random), {}, pose});
  return scans;
}

/// Through the offices. Made once.
[[nodiscard]] inline const std::vector<PosedScan>& office_drive() {
  static const std::vector<PosedScan> drive =
      posed_scans(offices(), drive_through_offices(0.4), 11);
  return drive;
}

}  // namespace cornerfix::testing
