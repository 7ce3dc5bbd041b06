#include "core/src/scan/rebinned_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cornerfix {
namespace {

constexpr float kNoReturn = std::numeric_limits<float>::quiet_NaN();
constexpr float kSameSurface = 0.1F;  // of the range

}  // namespace

RebinnedScan::RebinnedScan(LaserScan geometry)
    : scan_(std::move(geometry)), is_taken_(scan_.ranges.size(), false) {
  std::ranges::fill(scan_.ranges, kNoReturn);
}

void RebinnedScan::put_no_return(std::size_t beam) {
  put_range(static_cast<std::ptrdiff_t>(beam), kNoReturn);
}

void RebinnedScan::put(std::size_t beam, const Point2& point) {
  const double aside = wrap_angle(std::atan2(point.y(), point.x()) - scan_.bearing(beam));
  put_range(static_cast<std::ptrdiff_t>(beam) + std::lround(aside / scan_.angle_increment),
            static_cast<float>(point.norm()));
}

void RebinnedScan::put_range(std::ptrdiff_t beam, float range) {
  if (beam < 0 || beam >= static_cast<std::ptrdiff_t>(scan_.ranges.size())) return;
  const auto at = static_cast<std::size_t>(beam);
  if (is_taken_[at] && !(range < scan_.ranges[at]) && !std::isnan(scan_.ranges[at])) return;
  is_taken_[at] = true;
  scan_.ranges[at] = range;
}

LaserScan RebinnedScan::finish() && {
  std::vector<float>& ranges = scan_.ranges;
  for (std::size_t beam = 1; beam + 1 < ranges.size(); ++beam) {
    const float before = ranges[beam - 1];
    const float after = ranges[beam + 1];
    if (is_taken_[beam] || !is_taken_[beam - 1] || !is_taken_[beam + 1]) continue;
    if (std::abs(before - after) <= kSameSurface * std::min(before, after)) {
      ranges[beam] = 0.5F * (before + after);
    }
  }
  return std::move(scan_);
}

}  // namespace cornerfix
