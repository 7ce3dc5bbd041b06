/// \file  A submap feature paired with a map feature, true or not.
#pragma once

#include <cstddef>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

struct Correspondence {
  Point2 point_submap = Point2::Zero();  ///< [m]
  Point2 point_map = Point2::Zero();     ///< [m]
};

}  // namespace cornerfix
