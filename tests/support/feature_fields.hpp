/// \file  Maps of random features as dense as those of buildings, and submaps that share part of
/// them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "support/random_features.hpp"

namespace cornerfix::testing {

/// Features a square metre, as in the measurements of docs/results.md, "Matching".
constexpr double kFeatureDensity = 0.0177;

/// `count` features in a square.
[[nodiscard]] inline std::vector<Feature> feature_field(std::size_t count,
                                                        std::mt19937_64& random) {
  return random_features(count, std::sqrt(static_cast<double>(count) / kFeatureDensity), random);
}

struct SubmapOfField {
  std::vector<Feature> features;  ///< In `submap`.
  Pose2 T_map_submap;
};

/// What a robot sees around a random place. Of the `count` nearest features of the map it is the
/// share `overlap`, each displaced by noise, and as many strange ones as are missing.
[[nodiscard]] inline SubmapOfField submap_of_field(const std::vector<Feature>& map,
                                                   std::size_t count, double overlap,
                                                   double noise_m, std::mt19937_64& random) {
  std::uniform_real_distribution<double> turn(-std::numbers::pi, std::numbers::pi);
  const Point2 center = map[random() % map.size()].position;
  const Pose2 T_map_submap{center.x(), center.y(), turn(random)};
  std::vector<Feature> near = map;
  const auto end = near.begin() + static_cast<std::ptrdiff_t>(std::min(count, near.size()));
  std::ranges::partial_sort(near, end, {}, [&](const Feature& feature) {
    return (feature.position - center).squaredNorm();
  });
  near.erase(end, near.end());
  std::ranges::shuffle(near, random);
  near.resize(static_cast<std::size_t>(std::lround(overlap * static_cast<double>(near.size()))));
  SubmapOfField submap{seen_again(near, inverse(T_map_submap), noise_m, random), T_map_submap};
  const double radius =
      std::sqrt(static_cast<double>(count) / (std::numbers::pi * kFeatureDensity));
  std::uniform_real_distribution<double> share(0.0, 1.0);
  while (submap.features.size() < count) {
    const double r = radius * std::sqrt(share(random));
    const double bearing = turn(random);
    submap.features.push_back({.position = r * Point2(std::cos(bearing), std::sin(bearing))});
  }
  std::ranges::shuffle(submap.features, random);
  return submap;
}

}  // namespace cornerfix::testing
