/// \file  Time of the triangle index by the size of the map, one thread:
/// `cornerfix_micro_bench --benchmark_filter=Triangle`.
///
/// Each time is the mean over 200 submaps of 50 features, displaced by 0.05 m, in maps with 0.0177
/// features per square metre. `found` is the share of them that was matched at the true pose.
#include <benchmark/benchmark.h>

#include "core/src/matching/triangle_index.hpp"
#include "support/feature_fields.hpp"

namespace cornerfix {
namespace {

constexpr std::size_t kSubmaps = 200;
constexpr std::size_t kFeatures = 50;  // of a submap
constexpr double kNoise = 0.05;        // [m]

bool is_right(const std::vector<TriangleMatch>& matches, const Pose2& T_map_submap) {
  return !matches.empty() && distance(matches[0].T_map_submap, T_map_submap) < 0.2 &&
         angle_between(matches[0].T_map_submap, T_map_submap) < 0.02;
}

void triangle_match(benchmark::State& state) {
  std::mt19937_64 random(1);
  const auto map = testing::feature_field(static_cast<std::size_t>(state.range(0)), random);
  const double overlap = static_cast<double>(state.range(1)) / 100.0;
  std::vector<testing::SubmapOfField> submaps;
  for (std::size_t i = 0; i < kSubmaps; ++i)
    submaps.push_back(testing::submap_of_field(map, kFeatures, overlap, kNoise, random));
  const TriangleIndex index(map, {});
  std::size_t matched = 0;
  std::size_t found = 0;
  std::size_t wrong = 0;
  for (auto _ : state) {
    const testing::SubmapOfField& submap = submaps[matched++ % kSubmaps];
    const auto matches = index.match(submap.features, {});
    const bool right = is_right(matches, submap.T_map_submap);
    found += right ? 1 : 0;
    wrong += !right && !matches.empty() ? 1 : 0;
  }
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(matched);
  state.counters["wrong"] = static_cast<double>(wrong) / static_cast<double>(matched);
  state.counters["MB"] = static_cast<double>(index.memory_bytes()) * 1e-6;
}
BENCHMARK(triangle_match)
    ->Name("TriangleMatch")
    ->ArgNames({"features", "overlap_percent"})
    ->ArgsProduct({{300, 3'000, 30'000, 300'000}, {50, 30}})
    ->Unit(benchmark::kMillisecond);

void build_index(benchmark::State& state) {
  std::mt19937_64 random(1);
  const auto map = testing::feature_field(static_cast<std::size_t>(state.range(0)), random);
  for (auto _ : state) benchmark::DoNotOptimize(TriangleIndex(map, {}));
}
BENCHMARK(build_index)
    ->Name("TriangleIndex")
    ->RangeMultiplier(10)
    ->Range(300, 300'000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cornerfix
