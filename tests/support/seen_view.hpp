/// \file  What a robot has seen of a scene, as a localizer's search gets it.
#pragma once

#include <random>
#include <span>
#include <utility>

#include <cornerfix/corners.hpp>

#include "core/src/local_map/view.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix::testing {

/// The view from the last of `T_map_base_link`, after a scan at each of them.
[[nodiscard]] inline View view_along(const SceneBuilder& scene,
                                     std::span<const Pose2> T_map_base_link) {
  const Lidar lidar{.beams = 360, .noise_m = 0.01};
  std::mt19937_64 random(5);
  Submap submap;
  Pose2 T_submap_base_link;
  for (const Pose2& pose : T_map_base_link) {
    T_submap_base_link = inverse(T_map_base_link.front()) * pose;
    LaserScan scan = simulate_scan(scene, lidar, pose, random);
    auto corners = extract_corners(scan, CornerExtractor::kLineIntersection);
    submap.keep({0, std::move(scan), {}, T_submap_base_link}, std::move(corners));
  }
  return view_from(submap, T_submap_base_link);
}

}  // namespace cornerfix::testing
