/// \file  The default corners: intersections of lines fitted to the returns on both sides of a
/// point.
///
/// The paper's corner is a raw return and carries its whole noise. This one is the intersection of
/// two fitted lines. It is a corner by a likelihood ratio, two lines against one, which needs no
/// tuning to the noise.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

/// An oriented corner of one scan, in `laser`.
struct Corner {
  Point2 position = Point2::Zero();                      ///< [m]
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< Of the position [m^2].
  /// Heading of the bisector of both arms, into the smaller angle [rad].
  double bisector = 0.0;
  double turn_angle = 0.0;  ///< 0 on a straight wall, pi/2 at a right angle [rad].
  /// True where the obstacle juts out towards the sensor, false in the corner of a room.
  bool convex = false;
  /// Squared residuals that the second line saves, in units of the noise variance.
  double gain = 0.0;
};

struct LineIntersectionParams {
  double arm_length_m = 0.35;         ///< Of the first fit; at least 8 sigma of the noise; > 0.
  double max_arm_length_m = 2.0;      ///< Of the grown arms; >= arm_length_m.
  int min_arm_points = 3;             ///< >= 3
  double min_first_gain = 14.0;       ///< Before growth: low, or obtuse corners are lost; > 0.
  double min_gain = 30.0;             ///< After growth; > 0.
  double min_turn_angle_rad = 0.436;  ///< 25 deg; in (0, pi).
  double min_incidence_rad = 0.105;   ///< 6 deg: flatter arms are unreliable; in [0, pi/2).
  double min_noise_m = 0.0;           ///< Ranges are at least as noisy as this; >= 0.
};

[[nodiscard]] std::optional<Error> validate(const LineIntersectionParams& params);

/// Standard deviation of the range noise [m], from second differences of neighbouring returns; at
/// least 6 mm. O(beams).
[[nodiscard]] double estimate_range_noise(const LaserScan& scan);

/// By ascending beam; a corner at the seam of a full turn is found like any other. `scan` and
/// `params` must pass validate(). All numbers of a corner are finite. O(beams). Keeps no state.
[[nodiscard]] std::vector<Corner> extract_line_intersection_corners(
    const LaserScan& scan, const LineIntersectionParams& params);

}  // namespace cornerfix
