/// \file  The longest straight lines among hits.
#pragma once

#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Takes the line with the most hits within 0.2 m, then the line with the most of the others, and
/// so on. Each line is found by a Hough transform with cells of 1 deg and 0.2 m, and fitted to its
/// hits by least squares. Collinear walls are one line.
/// \param hits  In any frame [m].
/// \return Whether each hit is on one of the `count` lines.
/// O(180 count (hits + extent / 0.2 m)).
[[nodiscard]] std::vector<bool> are_on_longest_lines(std::span<const Point2> hits, int count);

}  // namespace cornerfix
