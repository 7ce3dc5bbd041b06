/// \file  MRPT's Monte Carlo localization, a rival that nobody here wrote: the door to its headers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include <cornerfix/occupancy_grid.hpp>

#include "bench/rivals/rival.hpp"

namespace cornerfix::bench {

struct MrptParams {
  std::size_t max_particles = 20'000;
  double power = 0.5;  ///< Of the likelihood (powFactor). 1 takes beams as independent and gathers
                       ///< too soon; 0.05 hardly gathers at all.
  double update_distance_m = 0.2;
  double update_angle_rad = 0.5236;
  std::uint32_t seed = 1;
};

/// A map as MRPT holds it; shared by its robots.
class MrptMap {
 public:
  explicit MrptMap(const OccupancyGrid& grid);
  ~MrptMap();
  MrptMap(const MrptMap&) = delete;
  MrptMap& operator=(const MrptMap&) = delete;

  [[nodiscard]] std::size_t bytes() const;

  struct Impl;
  [[nodiscard]] const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// CMonteCarloLocalization2D with KLD sampling and its default likelihood field of Thrun. Starts
/// all over the free space, or about a known pose: anywhere within 0.25 m and 7.5 deg of it. The
/// pose is given once the particles are no wider than 0.5 m, and from then on always. MRPT keeps
/// its random numbers in one place, and how many beams it takes in the map: one such robot at a
/// time.
[[nodiscard]] std::unique_ptr<Rival> make_mrpt_localizer(
    std::shared_ptr<const MrptMap> map, const MrptParams& params,
    const std::optional<Pose2>& T_map_base_link = {});

}  // namespace cornerfix::bench
