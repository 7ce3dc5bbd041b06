/// \file  Where a robot may be when its scans begin: a dock, a zone, the last known pose.
#pragma once

#include <numbers>
#include <optional>
#include <string>

#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// Poses that base_link may have at the first scan after Localizer::reset(). Poses outside are not
/// searched, also not as rivals, so the probability of an answer is conditional on the region.
struct StartRegion {
  std::string map{};                            ///< Name; empty: any of the localizer's maps.
  Point2 center = Point2::Zero();               ///< In `map` [m].
  double radius_m = 0.0;                        ///< > 0
  std::optional<double> yaw{};                  ///< In `map` [rad]; any when not given.
  double yaw_tolerance_rad = std::numbers::pi;  ///< To both sides of yaw; in (0, pi].

  friend bool operator==(const StartRegion&, const StartRegion&) = default;
};

[[nodiscard]] std::optional<Error> validate(const StartRegion& region);

}  // namespace cornerfix
