/// \file  The cross product of vectors in the plane.
#pragma once

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Twice the area of the triangle that they span; positive when b is to the left of a.
[[nodiscard]] inline double cross(const Point2& a, const Point2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace cornerfix
