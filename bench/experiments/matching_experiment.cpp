/// \file  Section 4.3, figure 8: NMA, RMA and triangles on random features: time, whether RMA finds
/// what NMA finds, success by overlap and noise, and maps of up to 300,000 features.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "bench/experiments/csv_file.hpp"
#include "bench/experiments/experiment.hpp"
#include "core/src/matching/descriptor_matcher.hpp"
#include "core/src/matching/pose_estimator.hpp"
#include "core/src/matching/triangle_index.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/metrics/pose_error.hpp"
#include "evaluation/metrics/processor_time.hpp"
#include "support/feature_fields.hpp"

namespace cornerfix::bench {
namespace {

using evaluation::mean;
using evaluation::thread_ms;

constexpr double kSide = 50.0;               // [m] of the square of figure 8
constexpr double kOverlap = 0.5;             // N / N_local of figure 8
constexpr int kMinVotes = 3;                 // S_t
constexpr std::size_t kSubmapFeatures = 50;  // in the sweeps and in large maps

struct MatchingArguments {
  std::size_t trials = 100;
  std::size_t largest = 300'000;
  std::filesystem::path out = ".";
};

struct Matched {
  std::optional<Pose2> T_map_submap;
  double ms = 0.0;
};

bool same_pose(const std::optional<Pose2>& a, const Pose2& b) {
  return a && evaluation::is_correct(evaluation::pose_error(*a, b));
}

/// A map of features as each method wants it.
class MatchedMap {
 public:
  MatchedMap(std::vector<Feature> features, double max_distance_m)
      : features_(std::move(features)),
        params_{.max_distance_m = max_distance_m},
        descriptors_(describe(features_, params_)),
        index_(descriptors_),
        triangles_(features_, {}) {}

  [[nodiscard]] const std::vector<Feature>& features() const { return features_; }
  [[nodiscard]] std::size_t index_bytes() const { return index_.bytes(); }
  [[nodiscard]] std::size_t triangle_bytes() const { return triangles_.memory_bytes(); }

  /// Without the submap's descriptors, which the paper's figure does not time either.
  [[nodiscard]] Matched nma(const std::vector<Feature>& submap) const {
    const DescriptorSet local = describe(submap, params_);
    const double begin = thread_ms();
    const auto matches = match_exhaustive(local, index_, kMinVotes, 1);
    return {pose_of(matches, submap, local), thread_ms() - begin};
  }

  [[nodiscard]] Matched rma(const std::vector<Feature>& submap, double overlap,
                            std::uint64_t seed) const {
    const DescriptorSet local = describe(submap, params_);
    const double begin = thread_ms();
    const auto matches = match_sampled(local, index_, kMinVotes, 1, {0.95, overlap, seed});
    return {pose_of(matches, submap, local), thread_ms() - begin};
  }

  [[nodiscard]] Matched triangles(const std::vector<Feature>& submap) const {
    const double begin = thread_ms();
    const auto matches = triangles_.match(submap, {});
    const double took = thread_ms() - begin;
    if (matches.empty()) return {std::nullopt, took};
    return {matches.front().T_map_submap, took};
  }

 private:
  [[nodiscard]] std::optional<Pose2> pose_of(const std::vector<DescriptorMatch>& matches,
                                             const std::vector<Feature>& submap,
                                             const DescriptorSet& local) const {
    if (matches.empty()) return std::nullopt;
    const DescriptorMatch& best = matches.front();
    std::vector<Correspondence> pairs;
    for (const auto& [m, n] : pairs_of(best, local[best.local_feature],
                                       descriptors_[best.global_feature], local.angle_bins())) {
      pairs.push_back({submap[m].position, features_[n].position});
    }
    const auto estimate = estimate_pose(pairs, {});
    return estimate ? std::optional(estimate->T_map_submap) : std::nullopt;
  }

  std::vector<Feature> features_;
  DescriptorParams params_;
  DescriptorSet descriptors_;
  DescriptorIndex index_;
  TriangleIndex triangles_;
};

/// Times and successes of one method over some trials.
struct Tally {
  std::vector<double> ms;
  std::size_t right = 0;

  void add(const Matched& matched, const Pose2& T_map_submap) {
    ms.push_back(matched.ms);
    right += same_pose(matched.T_map_submap, T_map_submap) ? 1 : 0;
  }
  [[nodiscard]] double share() const {
    return static_cast<double>(right) / static_cast<double>(ms.size());
  }
};

/// Half of the features are the map's, the others strange, anywhere in the square.
testing::SubmapOfField submap_of_square(const std::vector<Feature>& map, std::size_t count,
                                        std::mt19937_64& random) {
  std::uniform_real_distribution<double> turn(-std::numbers::pi, std::numbers::pi);
  const Pose2 T_map_submap{kSide / 2.0, kSide / 2.0, turn(random)};
  std::vector<Feature> shared = map;
  std::ranges::shuffle(shared, random);
  shared.resize(static_cast<std::size_t>(std::ceil(kOverlap * static_cast<double>(count))));
  auto strange = testing::random_features(count - shared.size(), kSide, random);
  shared.insert(shared.end(), strange.begin(), strange.end());
  return {testing::seen_again(shared, inverse(T_map_submap), 0.0, random), T_map_submap};
}

class MatchingExperiment {
 public:
  explicit MatchingExperiment(MatchingArguments arguments) : arguments_(std::move(arguments)) {}

  void run() const {
    figure8();
    sweeps();
    large_maps();
  }

 private:
  void figure8() const {
    CsvFile table(arguments_.out / "matching.csv",
                  "features,local,trials,nma_ms,rma_ms,triangles_ms,nma_right,rma_right,"
                  "triangles_right,rma_as_nma");
    const std::size_t trials = std::max<std::size_t>(2, arguments_.trials / 5);
    for (const std::size_t count : {50U, 100U, 200U, 300U}) {
      for (std::size_t local = 10; local < count; local += 10) {
        Tally nma;
        Tally rma;
        Tally triangles;
        std::size_t agreed = 0;
        for (std::uint64_t trial = 0; trial < trials; ++trial) {
          std::mt19937_64 random(1000 * count + local + 1'000'000 * trial);
          const MatchedMap map(testing::random_features(count, kSide, random), 2.0 * kSide);
          const auto submap = submap_of_square(map.features(), local, random);
          const Matched exhaustive = map.nma(submap.features);
          const Matched sampled = map.rma(submap.features, kOverlap, trial);
          nma.add(exhaustive, submap.T_map_submap);
          rma.add(sampled, submap.T_map_submap);
          triangles.add(map.triangles(submap.features), submap.T_map_submap);
          const bool same = exhaustive.T_map_submap
                                ? same_pose(sampled.T_map_submap, *exhaustive.T_map_submap)
                                : !sampled.T_map_submap;
          agreed += same ? 1 : 0;
        }
        table.row(count, local, trials, mean(nma.ms), mean(rma.ms), mean(triangles.ms), nma.share(),
                  rma.share(), triangles.share(),
                  static_cast<double>(agreed) / static_cast<double>(trials));
      }
    }
  }

  void sweeps() const {
    CsvFile table(arguments_.out / "matching_sweeps.csv",
                  "sweep,overlap,noise_m,trials,nma,rma,triangles");
    for (const double overlap : {0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0})
      sweep(table, "overlap", overlap, 0.05);
    for (const double noise : {0.0, 0.02, 0.05, 0.10, 0.15}) sweep(table, "noise", 0.5, noise);
  }

  void sweep(CsvFile& table, const char* name, double overlap, double noise) const {
    std::mt19937_64 random(7);
    const MatchedMap map(testing::feature_field(300, random), 60.0);
    Tally nma;
    Tally rma;
    Tally triangles;
    for (std::uint64_t trial = 0; trial < arguments_.trials; ++trial) {
      const auto submap =
          testing::submap_of_field(map.features(), kSubmapFeatures, overlap, noise, random);
      nma.add(map.nma(submap.features), submap.T_map_submap);
      rma.add(map.rma(submap.features, overlap, trial), submap.T_map_submap);
      triangles.add(map.triangles(submap.features), submap.T_map_submap);
    }
    table.row(name, overlap, noise, arguments_.trials, nma.share(), rma.share(), triangles.share());
  }

  void large_maps() const {
    CsvFile table(arguments_.out / "matching_large.csv",
                  "features,overlap,trials,rma_ms,rma_right,rma_index_bytes,triangles_ms,"
                  "triangles_right,triangles_index_bytes");
    for (std::size_t count = 300; count <= arguments_.largest; count *= 10) {
      std::mt19937_64 random(count);
      const MatchedMap map(testing::feature_field(count, random), 60.0);
      const std::size_t trials = std::max<std::size_t>(3, arguments_.trials / (count / 300));
      for (const double overlap : {0.5, 0.3}) {
        Tally rma;
        Tally triangles;
        for (std::uint64_t trial = 0; trial < trials; ++trial) {
          const auto submap =
              testing::submap_of_field(map.features(), kSubmapFeatures, overlap, 0.05, random);
          rma.add(map.rma(submap.features, overlap, trial), submap.T_map_submap);
          triangles.add(map.triangles(submap.features), submap.T_map_submap);
        }
        table.row(count, overlap, trials, mean(rma.ms), rma.share(), map.index_bytes(),
                  mean(triangles.ms), triangles.share(), map.triangle_bytes());
      }
    }
  }

  MatchingArguments arguments_;
};

}  // namespace

void add_matching_experiment(CLI::App& app) {
  auto arguments = std::make_shared<MatchingArguments>();
  CLI::App* command =
      app.add_subcommand("matching", "Section 4.3: NMA, RMA and triangles on random features");
  command->add_option("--trials", arguments->trials, "Of each point of a sweep")
      ->check(CLI::PositiveNumber);
  command->add_option("--largest", arguments->largest, "Features of the largest map");
  add_out_option(*command, arguments->out);
  command->callback([arguments] { MatchingExperiment(*arguments).run(); });
}

}  // namespace cornerfix::bench
