/// \file  Feature points without a building: seeded, anywhere in a square.
#pragma once

#include <cstddef>
#include <random>
#include <span>
#include <vector>

#include <cornerfix/corners.hpp>

namespace cornerfix::testing {

/// `count` features in [0, side_m] x [0, side_m].
[[nodiscard]] inline std::vector<Feature> random_features(std::size_t count, double side_m,
                                                          std::mt19937_64& random) {
  std::uniform_real_distribution<double> coordinate(0.0, side_m);
  std::vector<Feature> features(count);
  for (Feature& feature : features) feature.position = {coordinate(random), coordinate(random)};
  return features;
}

/// The same features in another frame, each displaced by noise.
[[nodiscard]] inline std::vector<Feature> seen_again(std::span<const Feature> features,
                                                     const Pose2& T_submap_map, double noise_m,
                                                     std::mt19937_64& random) {
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<Feature> seen;
  for (const Feature& feature : features) {
    seen.push_back(transformed(T_submap_map, feature));
    seen.back().position += noise_m * Point2(noise(random), noise(random));
  }
  return seen;
}

}  // namespace cornerfix::testing
