#include "core/src/map/field_stamp.hpp"

#include <cmath>
#include <optional>

namespace cornerfix {

template <typename Field>
void stamp_scan(Field& field, const LaserScan& scan, const Pose2& T_frame_laser, double radius_m,
                double max_range_m) {
  constexpr double kMaxLink = 0.5;  // neighbouring returns nearer than this lie on one wall [m]
  const Pose2 T_grid_laser = field.T_grid_frame() * T_frame_laser;
  const double spacing = field.resolution();
  std::optional<Point2> last;
  for (const Point2& point : returns_as_points(scan)) {
    if (point.norm() > max_range_m) continue;
    const Point2 here = T_grid_laser * point;
    const double gap = last ? (here - *last).norm() : kMaxLink;
    if (gap < 0.8 * spacing) continue;
    // Between returns on one wall the field must be a wall, not a row of dots that attract each
    // other.
    const int pieces = gap < kMaxLink ? static_cast<int>(std::ceil(gap / spacing)) : 1;
    for (int i = 1; i < pieces; ++i)
      field.stamp(*last + (here - *last) * (static_cast<double>(i) / pieces), radius_m);
    field.stamp(here, radius_m);
    last = here;
  }
}

template void stamp_scan(DistanceField&, const LaserScan&, const Pose2&, double, double);
template void stamp_scan(TiledField&, const LaserScan&, const Pose2&, double, double);

}  // namespace cornerfix
