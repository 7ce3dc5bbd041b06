/// \file  The walls that a scan saw, drawn into a distance field.
#pragma once

#include <cornerfix/laser_scan.hpp>

#include "core/src/map/tiled_field.hpp"

namespace cornerfix {

/// Stamps the returns within `max_range_m` and what lies between neighbours on one wall.
/// `T_frame_laser` leads into the field's frame. Field: DistanceField or TiledField.
template <typename Field>
void stamp_scan(Field& field, const LaserScan& scan, const Pose2& T_frame_laser, double radius_m,
                double max_range_m);

}  // namespace cornerfix
