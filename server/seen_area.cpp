#include "server/seen_area.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace cornerfix::server {
namespace {

constexpr double kAlwaysAllowedCells = 5e6;  // 110 x 110 m at 0.05 m; about a second of work.
constexpr double kMaxExtentPerSeen = 4.0;

double area_of(const Bounds& bounds) { return (bounds.max - bounds.min).prod(); }

}  // namespace

SeenArea::SeenArea(const Mapper& mapper, const MapperParams& params) {
  for (const PosedScan& key_frame : mapper.key_frames()) add(key_frame, params);
}

void SeenArea::add(const PosedScan& key_frame, const MapperParams& params) {
  area_m2_ += area_of(bounds_of(key_frame, params.grid));
}

std::optional<Error> SeenArea::reject(const std::optional<Bounds>& bounds,
                                      const MapperParams& params) const {
  const double always_allowed_m2 =
      kAlwaysAllowedCells * params.grid.resolution_m * params.grid.resolution_m;
  if (!bounds || area_of(*bounds) <= std::max(always_allowed_m2, kMaxExtentPerSeen * area_m2_))
    return std::nullopt;
  const Point2 size = bounds->max - bounds->min;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("the map would span {:.0f} x {:.0f} m, but its keyframes saw at most "
                           "{:.0f} m^2: are the poses right?",
                           size.x(), size.y(), area_m2_),
               ""};
}

}  // namespace cornerfix::server
