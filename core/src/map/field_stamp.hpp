/// \file  The walls that a scan saw, drawn into a distance field.
#pragma once

#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

/// Appends the returns within `max_range_m`, and points between neighbours on one wall, about
/// `spacing_m` apart: what to stamp into a field whose cells have that size.
void append_walls(std::vector<Point2>& points_grid, const LaserScan& scan,
                  const Pose2& T_grid_laser, double spacing_m, double max_range_m);

/// Stamps the walls of one scan. `T_frame_laser` leads into the field's frame. Field: DistanceField
/// or TiledField.
template <typename Field>
void stamp_scan(Field& field, const LaserScan& scan, const Pose2& T_frame_laser, double radius_m,
                double max_range_m) {
  std::vector<Point2> walls;
  append_walls(walls, scan, field.T_grid_frame() * T_frame_laser, field.resolution(), max_range_m);
  field.stamp(walls, radius_m);
}

}  // namespace cornerfix
