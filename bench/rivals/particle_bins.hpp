/// \file  The bins of a pose histogram that particles fall in: how many are filled, and which are
/// neighbours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix::bench {

/// Bins of 0.5 m, 0.5 m and 10 deg, as in ROS's AMCL.
class ParticleBins {
 public:
  void insert(const Pose2& T_map_base_link);

  /// Bins with a particle.
  [[nodiscard]] std::size_t size() const { return cluster_of_bin_.size(); }

  /// Makes clusters of bins that touch, if only in a corner, and numbers them from 0 on. Returns
  /// how many there are.
  std::size_t find_clusters();

  /// After find_clusters(), for a pose that was inserted.
  [[nodiscard]] std::size_t cluster_of(const Pose2& T_map_base_link) const;

 private:
  std::unordered_map<std::uint64_t, std::size_t> cluster_of_bin_;
};

}  // namespace cornerfix::bench
