/// \file  Time of each step of the paper's method, one thread:
/// `cornerfix_micro_bench --benchmark_filter=Vfp`.
///
/// Scans are taken in a room after the paper's figure 7. Matching is timed as in its section 4.3.
/// There are N random map features against N - 1 submap features, half of them shared, in 50 m by
/// 50 m with no pair left out.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "core/src/local_map/submap.hpp"
#include "core/src/matching/descriptor_matcher.hpp"
#include "core/src/matching/pose_estimator.hpp"
#include "core/src/scan/line_intersection_corners.hpp"
#include "core/src/scan/vfp_corners.hpp"
#include "support/random_features.hpp"
#include "support/room_drive.hpp"
#include "support/scan_simulator.hpp"

namespace cornerfix {
namespace {

constexpr double kSide = 50.0;
constexpr int kMinVotes = 6;
constexpr std::size_t kMaxMatches = 10;

/// Beams and range noise [mm] are the arguments.
LaserScan scan_for(const benchmark::State& state) {
  std::mt19937_64 random(1);
  return testing::simulate_scan(testing::figure7_room(),
                                {.beams = static_cast<std::size_t>(state.range(0)),
                                 .noise_m = static_cast<double>(state.range(1)) / 1000.0},
                                {7.5, 5.0, 0.3}, random);
}

void segments(benchmark::State& state) {
  const LaserScan scan = scan_for(state);
  for (auto _ : state) benchmark::DoNotOptimize(cut_into_segments(scan, {}));
}
BENCHMARK(segments)->Name("Segments")->ArgNames({"beams", "mm"})->Args({360, 30})->Args({1440, 30});

void vfp(benchmark::State& state) {
  const LaserScan scan = scan_for(state);
  const VfpParams params = vfp_params_for(scan.angle_increment);
  for (auto _ : state) benchmark::DoNotOptimize(extract_vfp_corners(scan, params));
}
BENCHMARK(vfp)
    ->Name("VfpCorners")
    ->ArgNames({"beams", "mm"})
    ->ArgsProduct({{360, 1440}, {0, 30, 70}});

void two_arm(benchmark::State& state) {
  const LaserScan scan = scan_for(state);
  for (auto _ : state) benchmark::DoNotOptimize(extract_line_intersection_corners(scan, {}));
}
BENCHMARK(two_arm)
    ->Name("TwoArmCorners")
    ->ArgNames({"beams", "mm"})
    ->ArgsProduct({{360, 1440}, {0, 30, 70}});

/// A scan of 1080 beams matched to the submap of the path that led to it, from odometry that is off
/// by some centimetres. The argument is the number of returns that are matched.
void scan_to_submap(benchmark::State& state) {
  constexpr double kStep = 0.15;  // 0.24 m along the circle
  const auto way = testing::circle_in_room(1.6, 0.0, kStep, 41);
  std::mt19937_64 random(1);
  const auto scan_at = [&](const Pose2& pose) {
    return testing::simulate_scan(testing::figure7_room(), {.beams = 1080, .noise_m = 0.02}, pose,
                                  random);
  };
  const Pose2 T_submap_map = inverse(way.front());
  Submap submap;
  for (const Pose2& pose : std::span(way).first(way.size() - 1)) {
    submap.keep({0, scan_at(pose), Pose2{}, T_submap_map * pose}, {});
  }
  std::vector<Point2> points = returns_as_points(scan_at(way.back()));
  std::ranges::shuffle(points, random);
  points.resize(std::min(points.size(), static_cast<std::size_t>(state.range(0))));
  const PosePrior prior =
      isotropic_prior(T_submap_map * way.back() * Pose2{0.05, -0.03, 0.02}, 0.05, 0.03);
  for (auto _ : state) benchmark::DoNotOptimize(submap.match(points, prior));
}
BENCHMARK(scan_to_submap)
    ->Name("ScanToSubmap")
    ->ArgName("points")
    ->Arg(360)
    ->Arg(1080)
    ->Unit(benchmark::kMicrosecond);

void feature_map_insert(benchmark::State& state) {
  std::mt19937_64 random(1);
  std::vector<std::vector<Feature>> scans;
  for (int scan = 0; scan < 500; ++scan) {
    scans.push_back(testing::random_features(12, kSide, random));
    for (Feature& corner : scans.back()) corner.weight = static_cast<double>(random() % 1000);
  }
  for (auto _ : state) {
    FeatureMap map;
    for (const std::vector<Feature>& corners : scans) map.insert(corners);
    benchmark::DoNotOptimize(map.features().data());
  }
  state.counters["per_corner"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * 500.0 * 12.0,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(feature_map_insert)->Name("FeatureMapInsert6000")->Unit(benchmark::kMicrosecond);

/// Features of a map and of a submap that shares half of them.
struct Features {
  std::vector<Feature> map;
  std::vector<Feature> submap;
};

Features features_for(std::size_t count) {
  std::mt19937_64 random(1);
  Features features;
  features.map = testing::random_features(count, kSide, random);
  features.submap =
      testing::seen_again(std::span(features.map).first(count / 2), {3.0, -4.0, 1.0}, 0.0, random);
  const auto others = testing::random_features(count - 1 - count / 2, kSide, random);
  features.submap.insert(features.submap.end(), others.begin(), others.end());
  return features;
}

constexpr DescriptorParams kAllPairs{.max_distance_m = 2.0 * kSide};

void describe_features(benchmark::State& state) {
  const Features features = features_for(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(describe(features.map, kAllPairs));
}
BENCHMARK(describe_features)->Name("Describe")->Arg(50)->Arg(300)->Unit(benchmark::kMicrosecond);

void index_descriptors(benchmark::State& state) {
  const Features features = features_for(static_cast<std::size_t>(state.range(0)));
  const DescriptorSet global = describe(features.map, kAllPairs);
  for (auto _ : state) benchmark::DoNotOptimize(DescriptorIndex(global));
}
BENCHMARK(index_descriptors)->Name("Index")->Arg(300)->Unit(benchmark::kMicrosecond);

template <typename Match>
void match(benchmark::State& state, Match match_with) {
  const Features features = features_for(static_cast<std::size_t>(state.range(0)));
  const DescriptorSet local = describe(features.submap, kAllPairs);
  const DescriptorIndex global(describe(features.map, kAllPairs));
  for (auto _ : state) benchmark::DoNotOptimize(match_with(local, global));
}

void rma(benchmark::State& state) {
  match(state, [](const DescriptorSet& local, const DescriptorIndex& global) {
    return match_sampled(local, global, kMinVotes, kMaxMatches, {});
  });
}
BENCHMARK(rma)->Name("RMA")->Arg(50)->Arg(100)->Arg(200)->Arg(300)->Unit(benchmark::kMillisecond);

void nma(benchmark::State& state) {
  match(state, [](const DescriptorSet& local, const DescriptorIndex& global) {
    return match_exhaustive(local, global, kMinVotes, kMaxMatches);
  });
}
BENCHMARK(nma)->Name("NMA")->Arg(50)->Arg(100)->Arg(200)->Arg(300)->Unit(benchmark::kMillisecond);

void ransac(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  const Features features = features_for(count);
  std::vector<Correspondence> correspondences;
  for (std::size_t i = 0; i < count - 1; ++i) {
    correspondences.push_back({features.submap[i].position, features.map[i].position});
  }
  for (auto _ : state) benchmark::DoNotOptimize(estimate_pose(correspondences, {}));
}
BENCHMARK(ransac)->Name("RANSAC")->Arg(20)->Arg(100)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace cornerfix
