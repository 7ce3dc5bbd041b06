#include "core/src/map/field_stamp.hpp"

#include <cmath>
#include <optional>
#include <vector>

namespace cornerfix {

void append_walls(std::vector<Point2>& points_grid, const LaserScan& scan,
                  const Pose2& T_grid_laser, double spacing_m, double max_range_m) {
  constexpr double kMaxLink = 0.5;  // neighbouring returns nearer than this lie on one wall [m]
  std::optional<Point2> last;
  for (const Point2& point : returns_as_points(scan)) {
    if (point.norm() > max_range_m) continue;
    const Point2 here = T_grid_laser * point;
    const double gap = last ? (here - *last).norm() : kMaxLink;
    if (gap < 0.8 * spacing_m) continue;
    // Between returns on one wall the field must be a wall, not a row of dots that attract each
    // other.
    const int pieces = gap < kMaxLink ? static_cast<int>(std::ceil(gap / spacing_m)) : 1;
    for (int i = 1; i < pieces; ++i)
      points_grid.emplace_back(*last + (here - *last) * (static_cast<double>(i) / pieces));
    points_grid.push_back(here);
    last = here;
  }
}

}  // namespace cornerfix
