#include "core/src/search/search_region.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cornerfix {
namespace {

constexpr double kDrift = 0.02;  // of the local map, per metre from its first scan

}  // namespace

SearchRegion::SearchRegion(StartRegion start, const Pose2& T_start_base_link)
    : start_(std::move(start)), T_start_base_link_(T_start_base_link) {}

SearchRegion SearchRegion::mirrored() const {
  const Pose2& motion = T_start_base_link_;
  return SearchRegion(start_, {motion.x, -motion.y, wrap_angle(-motion.yaw)});
}

bool SearchRegion::is_in(const LocalizationMap& map) const {
  return start_.map.empty() || start_.map == map.name();
}

double SearchRegion::radius_m() const {
  return start_.radius_m + kDrift * T_start_base_link_.translation().norm();
}

bool SearchRegion::contains(const Pose2& T_map_base_link, double slack_m, double slack_rad) const {
  if (!has_heading(T_map_base_link.yaw, slack_rad)) return false;
  const Disc disc = positions_at(T_map_base_link.yaw, slack_rad);
  return (T_map_base_link.translation() - disc.center).norm() <= disc.radius_m + slack_m;
}

bool SearchRegion::has_heading(double yaw, double slack_rad) const {
  if (!start_.yaw) return true;
  const double off = wrap_angle(yaw - T_start_base_link_.yaw - *start_.yaw);
  return std::abs(off) <= start_.yaw_tolerance_rad + slack_rad;
}

Disc SearchRegion::positions_at(double yaw, double slack_rad) const {
  const Pose2 T_base_link_start = inverse(T_start_base_link_);
  const Point2 start_from_here =
      Pose2{0.0, 0.0, yaw} * T_base_link_start.translation();  // in the axes of `map`
  return {start_.center - start_from_here, radius_m() + slack_rad * start_from_here.norm()};
}

double SearchRegion::free_area_m2(const LocalizationMap& map) const {
  if (!is_in(map)) return 0.0;
  const OccupancyGrid& grid = map.grid();
  const Point2 center = (inverse(grid.T_map_grid) * start_.center) / grid.resolution;
  const double radius = start_.radius_m / grid.resolution;
  const auto cell = [](double at, int size) {
    return static_cast<int>(std::clamp(std::floor(at), 0.0, static_cast<double>(size)));
  };
  std::size_t free = 0;
  for (int row = cell(center.y() - radius, grid.height);
       row < cell(center.y() + radius + 1.0, grid.height); ++row) {
    const double across = row + 0.5 - center.y();
    const double half = std::sqrt(std::max(0.0, radius * radius - across * across));
    for (int column = cell(center.x() - half, grid.width);
         column < cell(center.x() + half + 1.0, grid.width); ++column)
      free += grid.at({column, row}) == Cell::kFree ? 1U : 0U;
  }
  const double headings = start_.yaw ? start_.yaw_tolerance_rad / std::numbers::pi : 1.0;
  return static_cast<double>(free) * grid.resolution * grid.resolution * headings;
}

}  // namespace cornerfix
