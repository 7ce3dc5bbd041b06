/// \file  A large map from its SQLite file to ready for localizing, and the memory it takes there:
/// `cornerfix_pipeline_bench --benchmark_filter=LoadMap`.
///
/// The map is of a hall full of crates, made by the mapper from simulated scans. Counters: what the
/// map has; `map_MB`, what it keeps allocated once it is loaded; `rss_MB`, by how much the process
/// grew, with what loading left behind.
#include <benchmark/benchmark.h>
#include <malloc.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>

#include "server/map_library.hpp"
#include "support/drawn_grid.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::server {
namespace {

constexpr double kSide = 130.0;
constexpr int kCratesARow = 38;  ///< One every 3.4 m.
constexpr std::size_t kKeyFrames = 2000;
constexpr std::size_t kBeams = 1080;
constexpr std::size_t kBatch = 100;
constexpr const char* kName = "hall";

template <typename T>
T value_of(Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "map_load_bench: %s\n", result.error().message.c_str());
  std::exit(1);
}

OccupancyGrid hall() {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> turn(-1.5, 1.5);
  testing::SceneBuilder scene =
      testing::SceneBuilder().room({0.5, 0.5}, {kSide - 0.5, kSide - 0.5});
  constexpr double kSpacing = kSide / kCratesARow;
  for (int i = 0; i < kCratesARow * kCratesARow; ++i) {
    const Point2 center((i % kCratesARow + 0.5) * kSpacing, (i / kCratesARow + 0.5) * kSpacing);
    scene.box(center, {1.0, 0.8}, turn(random));
  }
  return testing::drawn_grid(scene, {1.0, 1.0}, {}, {kSide, kSide}, 0.05);
}

/// From random places of the hall.
std::vector<PosedScan> mapping_scans() {
  const RayCaster caster(hall());
  LaserScan lidar;
  lidar.angle_increment = 2.0 * std::numbers::pi / kBeams;
  lidar.angle_min = -std::numbers::pi;
  lidar.range_min = 0.05;
  lidar.range_max = 30.0;
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> coordinate(1.0, kSide - 1.0);
  std::vector<PosedScan> scans;
  while (scans.size() < kKeyFrames) {
    const Pose2 pose{coordinate(random), coordinate(random), 0.0};
    if (caster.clearance(pose.translation()) < 0.3) continue;
    scans.push_back({caster.scan(lidar, kBeams, pose), Pose2{}, pose});
    scans.back().scan.stamp = static_cast<double>(scans.size());
  }
  return scans;
}

/// A database with the map, all that is derived from its keyframes included.
class StoredMap {
 public:
  StoredMap() {
    MapLibrary maps = library();
    value_of(maps.put(kName, {}));
    const std::vector<PosedScan> scans = mapping_scans();
    for (std::size_t i = 0; i < scans.size(); i += kBatch) {
      key_frames_ = value_of(maps.grow(kName, std::span(scans).subspan(i, kBatch))).key_frames;
    }
    value_of(maps.load(kName));
  }

  /// One that has loaded nothing yet.
  [[nodiscard]] MapLibrary library() const {
    return {stores_, {}, [] { return std::string("2026-01-01T00:00:00Z"); }};
  }
  [[nodiscard]] std::size_t key_frames() const { return key_frames_; }

 private:
  testing::TemporaryDirectory directory_;
  std::shared_ptr<StoreAccess> stores_ = value_of(StoreAccess::open(directory_ / "maps.db"));
  std::size_t key_frames_ = 0;
};

double allocated_mb() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  file >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

void load_map(benchmark::State& state) {
  static const StoredMap stored;
  malloc_trim(0);
  const double allocated = allocated_mb();
  const double resident = resident_mb();
  {
    MapLibrary maps = stored.library();
    const LocalizationMapPtr map = value_of(maps.load(kName));
    state.counters["key_frames"] = static_cast<double>(stored.key_frames());
    state.counters["features"] = static_cast<double>(map->features().size());
    state.counters["cells"] = static_cast<double>(map->grid().cells.size());
    state.counters["map_MB"] = allocated_mb() - allocated;
    state.counters["rss_MB"] = resident_mb() - resident;
  }
  for (auto _ : state) {
    MapLibrary maps = stored.library();
    benchmark::DoNotOptimize(value_of(maps.load(kName)));
  }
}
BENCHMARK(load_map)->Name("LoadMap")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cornerfix::server
