/// \file  Times of the steps from a scan to candidate poses, in Willow Garage's occupancy map with
/// 1080 beams. The steps are the search through the whole map, refinement, and scoring of a pose.
/// One thread, the places in turn. `cornerfix_micro_bench --benchmark_filter=Verify`.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <cornerfix/map_image.hpp>
#include <cornerfix/occupancy_grid.hpp>

#include "core/src/map/distance_field.hpp"
#include "core/src/map/evidence_model.hpp"
#include "core/src/matching/scan_refiner.hpp"
#include "core/src/scan/evidence_grid.hpp"
#include "core/src/search/place_search.hpp"

namespace cornerfix {
namespace {

constexpr std::size_t kBeams = 1080;
constexpr std::size_t kPlaces = 20;

OccupancyGrid willow() {
  Result<OccupancyGrid> grid = read_map_files(CORNERFIX_WILLOW_MAP);
  if (grid) return std::move(*grid);
  std::fprintf(stderr, "verify_bench: %s\n", grid.error().message.c_str());
  std::exit(1);
}

/// The map, and what robots see at random places of it.
struct Building {
  OccupancyGrid grid = willow();
  DistanceField field{grid};
  ClassField classes{grid, field};
  PlaceSearch search{classes};
  std::vector<Pose2> poses;
  std::vector<Evidence> seen;

  Building() {
    const RayCaster caster(grid);
    LaserScan lidar;
    lidar.angle_increment = 1.5 * std::numbers::pi / kBeams;
    lidar.angle_min = -0.75 * std::numbers::pi;
    lidar.range_min = 0.05;
    lidar.range_max = 30.0;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    while (poses.size() < kPlaces) {
      const Point2 at_grid(share(random) * grid.width * grid.resolution,
                           share(random) * grid.height * grid.resolution);
      const Point2 at = grid.T_map_grid * at_grid;
      const Pose2 pose{at.x(), at.y(), 2.0 * std::numbers::pi * share(random) - std::numbers::pi};
      if (grid.at(grid.cell_of(at_grid)) != Cell::kFree || caster.clearance(at) < 0.4) continue;
      EvidenceGrid evidence;
      evidence.add(caster.scan(lidar, kBeams, pose), {});
      poses.push_back(pose);
      seen.push_back(evidence.collect());
    }
  }
};

const Building& building() {
  static const Building one;
  return one;
}

void search_map(benchmark::State& state) {
  const std::vector<Point2> here{Point2::Zero()};
  std::size_t i = 0;
  for (auto _ : state) {
    const Evidence& seen = building().seen[i++ % kPlaces];
    benchmark::DoNotOptimize(building().search.find(
        seen.ends, here,
        {.min_mean_weight = -0.5, .max_mean_gap = static_cast<double>(state.range(0)) / 100.0}));
  }
}
BENCHMARK(search_map)
    ->Name("Verify/search")
    ->ArgName("gap_percent")
    ->Arg(5)
    ->Arg(30)
    ->Unit(benchmark::kMillisecond);

void refine(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t place = i++ % kPlaces;
    benchmark::DoNotOptimize(refine_pose(building().field, building().seen[place].ends,
                                         building().poses[place] * Pose2{0.1, -0.1, 0.02},
                                         {.kernel_m = 0.4}));
  }
}
BENCHMARK(refine)->Name("Verify/refine")->Unit(benchmark::kMicrosecond);

void judge(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t place = i++ % kPlaces;
    benchmark::DoNotOptimize(
        score_evidence(building().classes, building().seen[place], building().poses[place]));
  }
}
BENCHMARK(judge)->Name("Verify/judge")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace cornerfix
