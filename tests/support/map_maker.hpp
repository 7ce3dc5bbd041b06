/// \file  Maps of scenes, made as a mapping run makes them.
#pragma once

#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/localization_map.hpp>
#include <cornerfix/mapper.hpp>

#include "support/simulated_drive.hpp"

namespace cornerfix::testing {

/// Points of a lattice that one gets to from `start` with `clearance_m` to all walls.
[[nodiscard]] inline std::vector<Point2> reachable(const SceneBuilder& scene, const Point2& start,
                                                   double spacing_m = 1.0,
                                                   double clearance_m = 0.35) {
  std::set<std::pair<int, int>> visited{{0, 0}};
  std::vector<std::pair<int, int>> open{{0, 0}};
  std::vector<Point2> points;
  while (!open.empty()) {
    const auto [column, row] = open.back();
    open.pop_back();
    const Point2 here = start + spacing_m * Point2(column, row);
    points.push_back(here);
    const std::pair<int, int> steps[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (const auto& [dx, dy] : steps) {
      const Point2 there = start + spacing_m * Point2(column + dx, row + dy);
      // A point in a wall has no clearance that rays could measure: stop before it.
      if (scene.range(here, std::atan2(dy, dx)) < spacing_m + clearance_m) continue;
      if (clearance(scene, there) < clearance_m) continue;
      if (visited.insert({column + dx, row + dy}).second) open.emplace_back(column + dx, row + dy);
    }
  }
  return points;
}

/// Scans from all over the free space about `inside`.
[[nodiscard]] inline std::vector<PosedScan> mapping_scans(const SceneBuilder& scene,
                                                          const Point2& inside) {
  const Lidar lidar{.beams = 360, .noise_m = 0.005};
  std::mt19937_64 random(99);
  std::vector<PosedScan> scans;
  for (const Point2& p : reachable(scene, inside)) {
    const Pose2 pose{p.x(), p.y(), 0.0};
    scans.push_back({simulate_scan(scene, lidar, pose, random), {}, pose});
  }
  return scans;
}

[[nodiscard]] inline MapContent map_content(const std::vector<PosedScan>& scans) {
  Mapper mapper;
  for (const PosedScan& scan : scans) mapper.add(scan);
  return mapper.build();
}

/// The map of the free space about `inside`.
[[nodiscard]] inline LocalizationMapPtr make_map(const SceneBuilder& scene, const Point2& inside,
                                                 std::string name = "map",
                                                 std::uint64_t revision = 1) {
  return std::make_shared<const LocalizationMap>(std::move(name), revision,
                                                 map_content(mapping_scans(scene, inside)));
}

}  // namespace cornerfix::testing
