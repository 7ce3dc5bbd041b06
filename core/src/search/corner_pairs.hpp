/// \file  Pairs of corners, and what of them does not depend on the pose of who sees them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <cornerfix/map_sketch.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

struct OrientedCorner {
  Point2 position;        ///< [m]
  double bisector = 0.0;  ///< [rad]
  bool convex = false;
};

/// Two corners in an order.
struct CornerPair {
  double distance_m = 0.0;
  double first_angle = 0.0;   ///< Bisector of the first corner, from the line to the second [rad].
  double second_angle = 0.0;  ///< The same of the second corner, from the same line [rad].
  bool first_convex = false;
  bool second_convex = false;
  Pose2 T_frame_pair;  ///< Origin at the first corner, x towards the second.
};

inline constexpr double kMinPairDistance = 1.0;   ///< Nearer corners give no good heading [m].
inline constexpr double kMaxPairDistance = 16.0;  ///< [m]
inline constexpr double kPairDistanceStep = 0.5;  ///< Width of a class of distances [m].
inline constexpr std::size_t kPairDistances = 30;
inline constexpr std::size_t kPairAngles = 24;  ///< Classes of an angle, 15 deg each.
/// All classes of pairs.
inline constexpr std::size_t kPairKeys = kPairDistances * kPairAngles * kPairAngles * 4;

/// Nothing when they are too near or too far.
[[nodiscard]] std::optional<CornerPair> corner_pair(const OrientedCorner& first,
                                                    const OrientedCorner& second);

/// Its class, below kPairKeys.
[[nodiscard]] std::size_t key_of(const CornerPair& pair);
/// Appends the classes of pairs whose distance differs by at most 0.2 m and whose angles differ by
/// at most 0.12 rad.
void keys_near(const CornerPair& pair, std::vector<std::size_t>& keys);

/// Each corner with up to `max_neighbors` of those nearest to it, from kMinPairDistance on. Each
/// pair comes once, i < j. O(n * corners nearby).
[[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint32_t>> neighboring_pairs(
    std::span<const SketchCorner> corners, std::size_t max_neighbors);

}  // namespace cornerfix
