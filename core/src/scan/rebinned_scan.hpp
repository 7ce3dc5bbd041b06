/// \file  A scan whose returns have moved, put back into beams of equal steps.
#pragma once

#include <cstddef>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

/// Each put() takes one beam. Of several returns at one beam the nearest stays.
class RebinnedScan {
 public:
  /// Beams at the bearings of `geometry`, as many as it has ranges, all without return.
  explicit RebinnedScan(LaserScan geometry);

  /// A beam without return; it lies at `beam`.
  void put_no_return(std::size_t beam);
  /// A return at `point` in `laser`, from a beam that lay at `beam` or near it.
  void put(std::size_t beam, const Point2& point);

  /// The scan. A single beam that nothing moved to gets the mean of its neighbours if they are of
  /// one surface.
  [[nodiscard]] LaserScan finish() &&;

 private:
  void put_range(std::ptrdiff_t beam, float range);

  LaserScan scan_;
  std::vector<bool> is_taken_;
};

}  // namespace cornerfix
