#include "bench/rivals/particle_bins.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace cornerfix::bench {
namespace {

constexpr double kBinMetres = 0.5;
constexpr std::int64_t kHeadings = 36;
constexpr std::size_t kNoCluster = std::numeric_limits<std::size_t>::max();

struct Bin {
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t heading = 0;  ///< In [0, kHeadings).
};

Bin bin_of(const Pose2& pose) {
  const double turn = (pose.yaw + std::numbers::pi) / (2.0 * std::numbers::pi);
  const auto heading = static_cast<std::int64_t>(turn * static_cast<double>(kHeadings));
  return {static_cast<std::int64_t>(std::floor(pose.x / kBinMetres)),
          static_cast<std::int64_t>(std::floor(pose.y / kBinMetres)), heading % kHeadings};
}

std::uint64_t key_of(const Bin& bin) {
  constexpr std::int64_t kOffset = 1 << 23;
  return (static_cast<std::uint64_t>(bin.column + kOffset) << 32) |
         (static_cast<std::uint64_t>(bin.row + kOffset) << 8) |
         static_cast<std::uint64_t>(bin.heading);
}

Bin bin_of_key(std::uint64_t key) {
  constexpr std::int64_t kOffset = 1 << 23;
  return {static_cast<std::int64_t>(key >> 32) - kOffset,
          static_cast<std::int64_t>((key >> 8) & 0xffffff) - kOffset,
          static_cast<std::int64_t>(key & 0xff)};
}

std::array<std::uint64_t, 27> neighborhood(std::uint64_t key) {
  const Bin bin = bin_of_key(key);
  std::array<std::uint64_t, 27> keys{};
  std::size_t i = 0;
  for (const int x : {-1, 0, 1}) {
    for (const int y : {-1, 0, 1}) {
      for (const int turn : {-1, 0, 1}) {
        keys[i++] =
            key_of({bin.column + x, bin.row + y, (bin.heading + turn + kHeadings) % kHeadings});
      }
    }
  }
  return keys;
}

}  // namespace

void ParticleBins::insert(const Pose2& T_map_base_link) {
  cluster_of_bin_.try_emplace(key_of(bin_of(T_map_base_link)), kNoCluster);
}

std::size_t ParticleBins::find_clusters() {
  std::size_t clusters = 0;
  for (auto& [first, first_cluster] : cluster_of_bin_) {
    if (first_cluster != kNoCluster) continue;
    first_cluster = clusters;
    std::vector<std::uint64_t> open{first};
    while (!open.empty()) {
      const std::uint64_t bin = open.back();
      open.pop_back();
      for (const std::uint64_t neighbor : neighborhood(bin)) {
        const auto found = cluster_of_bin_.find(neighbor);
        if (found == cluster_of_bin_.end() || found->second != kNoCluster) continue;
        found->second = clusters;
        open.push_back(neighbor);
      }
    }
    ++clusters;
  }
  return clusters;
}

std::size_t ParticleBins::cluster_of(const Pose2& T_map_base_link) const {
  return cluster_of_bin_.at(key_of(bin_of(T_map_base_link)));
}

}  // namespace cornerfix::bench
