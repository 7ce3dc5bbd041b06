/// \file  Whether robots can be localized in a map, place by place, before one is sent there.
///
/// Simulated robots are started all over the free space of the map's own grid, in several
/// directions, and drive until they are localized. Localizability is low where the map shows too
/// little, or where another pose fits as well. People, and what has changed since the map was made,
/// are not simulated: robots in the building need as much or more.
#pragma once

#include <cstddef>
#include <functional>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/answer.hpp>
#include <cornerfix/laser_scan.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// A robot's lidar and where it is mounted; the default sees half a turn, 30 m far.
struct SimulatedRobot {
  LaserScan lidar{.stamp = 0.0,
                  .angle_min = -0.5 * std::numbers::pi,
                  .angle_increment = std::numbers::pi / 180.0,
                  .range_min = 0.05,
                  .range_max = 30.0,
                  .ranges = {}};  ///< Ranges are ignored.
  std::size_t beams = 181;        ///< >= 1.
  Pose2 T_base_link_laser;
};

struct LocalizabilityParams {
  SimulatedRobot robot{};
  double lattice_m = 1.5;        ///< Between places, or more where that gives too many; > 0.
  std::size_t max_places = 300;  ///< Bounds the time; >= 1.
  double way_m = 20.0;           ///< Driving allowed until localized; > 0.
};

/// What happens to a robot that is switched on at a pose and drives ahead where there is room.
struct AssessedStart {
  Pose2 T_map_base_link;
  std::optional<double> way_m;  ///< Driven until localized; nothing when it never was.
  bool is_wrong = false;        ///< The first pose was a wrong one.
  double confidence = 0.0;      ///< In the true pose, before it drove; in [0, 1].
  std::optional<Pose2> rival;   ///< Another possible start pose, from when it last was `ambiguous`.
  double rival_way_m = 0.0;     ///< Driven until then.
};

struct AssessedPlace {
  Point2 position_map = Point2::Zero();
  std::size_t features_near = 0;      ///< Features of the map within 6 m.
  std::vector<AssessedStart> starts;  ///< Four, looking along the longest free way, left, back and
                                      ///< right.
};

/// Two aliased starts: they could not be distinguished until `way_m` was driven.
struct AliasedPoses {
  Pose2 T_map_a;
  Pose2 T_map_b;
  double way_m = 0.0;      ///< The most that any of `starts` drove.
  std::size_t starts = 0;  ///< Simulated ones for which one stood for the other.
};

struct LocalizabilityReport {
  SimulatedRobot robot{};
  double way_limit_m = 0.0;
  double lattice_m = 0.0;                 ///< As it was in the end.
  double free_area_m2 = 0.0;              ///< Of the map.
  std::size_t features = 0;               ///< Of the map.
  std::vector<AssessedPlace> places;      ///< Row by row.
  std::vector<AliasedPoses> look_alikes;  ///< Those that take longest to distinguish first.
};

/// Mean over the starts of a place; one that was not localized counts with the whole limit [m].
[[nodiscard]] double expected_way_m(const AssessedPlace& place, double way_limit_m);

/// Called with the share done, in [0, 1]; the assessment ends when it returns false. May be empty.
using AssessmentProgress = std::function<bool(double)>;

/// Deterministic. Ranges have noise of 2 cm; odometry is exact. Some 20 ms to 50 ms a start, in
/// mazes of equal corridors ten times that.
///
/// \return Nothing when `progress` returned false. A map without free space has no places.
[[nodiscard]] std::optional<LocalizabilityReport> assess_localizability(
    const LocalizationMapPtr& map, const LocalizabilityParams& params = {},
    const AssessmentProgress& progress = {});

/// The same for given starts, in their order.
[[nodiscard]] std::vector<AssessedStart> assess_starts(const LocalizationMapPtr& map,
                                                       std::span<const Pose2> T_map_base_link,
                                                       const LocalizabilityParams& params);

/// Neighbouring places from where robots drive 3 m or more until they are localized.
struct LowLocalizabilityRegion {
  Point2 center_map = Point2::Zero();
  double radius_m = 0.0;            ///< To the farthest of its places.
  std::vector<std::size_t> places;  ///< Ascending indices into the report's.
  double way_m = 0.0;               ///< Mean of what its starts need.
  double found = 0.0;               ///< Share of its starts that are localized at all.
  /// Another place that half or more of its starts were taken for, or that could not be excluded;
  /// nothing when too little is seen here instead.
  std::optional<Point2> look_alike_map;
  std::optional<Point2> easy_map;  ///< The nearest place where standing still is enough.
};

/// Hardest first: by the number of places times what they need.
[[nodiscard]] std::vector<LowLocalizabilityRegion> find_low_localizability_regions(
    const LocalizabilityReport& report);

}  // namespace cornerfix
