#include <cornerfix/localizability.hpp>

#include <algorithm>
#include <cmath>
#include <random>

#include <cornerfix/localizer.hpp>

#include "core/src/assessment/simulated_run.hpp"
#include "core/src/scan/simulated_scan.hpp"

namespace cornerfix {
namespace {

constexpr double kRobotClearance = 0.3;  // of a place from walls [m]
constexpr double kFeatureRadius = 6.0;   // [m]
constexpr double kRangeNoise = 0.02;     // [m]
constexpr double kRightDistance = 0.5;   // [m]
constexpr double kRightAngle = 5.0 * std::numbers::pi / 180.0;
constexpr double kOwnPlace = 1.0;  // nearer than this a hypothesis is no other place [m]
constexpr int kHeadings = 4;
constexpr std::size_t kMaxLookAlikes = 20;

struct Lattice {
  double spacing_m = 0.0;
  std::vector<Point2> positions_map;
};

/// No more places than allowed: the lattice grows until they are few enough.
Lattice make_lattice(const SimulatedLidar& lidar, const LocalizabilityParams& params) {
  Lattice lattice{params.lattice_m, lidar.viewpoints(params.lattice_m, kRobotClearance)};
  while (lattice.positions_map.size() > params.max_places) {
    const double excess =
        static_cast<double>(lattice.positions_map.size()) / static_cast<double>(params.max_places);
    lattice.spacing_m *= std::max(1.05, std::sqrt(excess));
    lattice.positions_map = lidar.viewpoints(lattice.spacing_m, kRobotClearance);
  }
  return lattice;
}

/// Where the farthest wall stands: along a corridor.
double longest_way(const SimulatedLidar& lidar, const Point2& position_map) {
  const LaserScan around = lidar.scan(position_map);
  std::size_t best = 0;
  double farthest = 0.0;
  for (std::size_t beam = 0; beam < around.ranges.size(); ++beam) {
    if (!around.has_return(beam) || around.ranges[beam] <= farthest) continue;
    farthest = around.ranges[beam];
    best = beam;
  }
  return around.bearing(best);
}

bool is_right(const Pose2& answered, const Pose2& truth) {
  return distance(answered, truth) <= kRightDistance &&
         angle_between(answered, truth) <= kRightAngle;
}

RobotScan take_scan(const SimulatedLidar& lidar, const SimulatedRobot& robot,
                    const Pose2& T_map_base_link, std::mt19937_64& random) {
  RobotScan taken{lidar.scan(robot.lidar, robot.beams, T_map_base_link * robot.T_base_link_laser),
                  robot.T_base_link_laser, T_map_base_link};
  std::normal_distribution<float> noise(0.0F, static_cast<float>(kRangeNoise));
  for (float& range : taken.scan.ranges) range += noise(random);
  return taken;
}

const RankedHypothesis* best_other(const Answer& answer, const Pose2& truth) {
  const auto other = std::ranges::find_if(answer.hypotheses, [&](const RankedHypothesis& ranked) {
    return distance(ranked.T_map_base_link, truth) > kOwnPlace;
  });
  return other == answer.hypotheses.end() ? nullptr : &*other;
}

bool leads_with(const Answer& answer, const Pose2& truth) {
  return !answer.hypotheses.empty() && is_right(answer.hypotheses.front().T_map_base_link, truth);
}

AssessedStart assess_start(const LocalizationMapPtr& map, const SimulatedLidar& lidar,
                           const Pose2& T_map_base_link, const LocalizabilityParams& params) {
  AssessedStart start;
  start.T_map_base_link = T_map_base_link;
  std::mt19937_64 random(1);  // NOLINT: every start sees the same noise, in whatever order
  Localizer localizer({map}, LocalizerParams{});
  const std::vector<Pose2> drive = simulated_run(lidar, T_map_base_link, params.way_m);
  double way_m = 0.0;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    if (i > 0) way_m += distance(drive[i - 1], drive[i]);
    RobotScan scan = take_scan(lidar, params.robot, drive[i], random);
    scan.scan.stamp = static_cast<double>(i);
    const Answer answer = localizer.process(scan);
    if (i == 0 && leads_with(answer, drive[i])) start.confidence = answer.confidence;
    if (answer.status == Status::kLocalized) {
      start.is_wrong = !leads_with(answer, drive[i]);
      if (!start.is_wrong) start.way_m = way_m;
      break;
    }
    const RankedHypothesis* other = best_other(answer, drive[i]);
    if (answer.status != Status::kAmbiguous || other == nullptr) continue;
    start.rival = other->T_map_base_link * inverse(answer.T_submap_base_link);
    start.rival_way_m = way_m;
  }
  return start;
}

AssessedPlace assess_place(const LocalizationMapPtr& map, const SimulatedLidar& lidar,
                           const Point2& position_map, const LocalizabilityParams& params) {
  AssessedPlace place{.position_map = position_map, .features_near = 0, .starts = {}};
  place.features_near =
      static_cast<std::size_t>(std::ranges::count_if(map->features(), [&](const Feature& feature) {
        return (feature.position - position_map).norm() <= kFeatureRadius;
      }));
  const Pose2 ahead{position_map.x(), position_map.y(), longest_way(lidar, position_map)};
  for (int i = 0; i < kHeadings; ++i) {
    const Pose2 turn{0.0, 0.0, wrap_angle(2.0 * std::numbers::pi * i / kHeadings)};
    place.starts.push_back(assess_start(map, lidar, ahead * turn, params));
  }
  return place;
}

/// Whether a pair of starts is another one, either way round.
bool is_same_pair(const AliasedPoses& pair, const Pose2& a, const Pose2& b, double near_m) {
  const auto is_near = [near_m](const Pose2& p, const Pose2& q) { return distance(p, q) < near_m; };
  return (is_near(pair.T_map_a, a) && is_near(pair.T_map_b, b)) ||
         (is_near(pair.T_map_a, b) && is_near(pair.T_map_b, a));
}

std::vector<AliasedPoses> find_look_alikes(const LocalizabilityReport& report) {
  std::vector<const AssessedStart*> confused;
  for (const AssessedPlace& place : report.places) {
    for (const AssessedStart& start : place.starts) {
      if (start.rival) confused.push_back(&start);
    }
  }
  std::ranges::stable_sort(confused, std::greater{}, &AssessedStart::rival_way_m);
  std::vector<AliasedPoses> pairs;
  for (const AssessedStart* start : confused) {
    const auto known = std::ranges::find_if(pairs, [&](const AliasedPoses& pair) {
      return is_same_pair(pair, start->T_map_base_link, *start->rival, 1.5 * report.lattice_m);
    });
    if (known != pairs.end()) {
      ++known->starts;
    } else {
      pairs.push_back({start->T_map_base_link, *start->rival, start->rival_way_m, 1});
    }
  }
  if (pairs.size() > kMaxLookAlikes) pairs.resize(kMaxLookAlikes);
  return pairs;
}

}  // namespace

double expected_way_m(const AssessedPlace& place, double way_limit_m) {
  double sum = 0.0;
  for (const AssessedStart& start : place.starts) sum += start.way_m.value_or(way_limit_m);
  return place.starts.empty() ? way_limit_m : sum / static_cast<double>(place.starts.size());
}

std::optional<LocalizabilityReport> assess_localizability(const LocalizationMapPtr& map,
                                                          const LocalizabilityParams& params,
                                                          const AssessmentProgress& progress) {
  const OccupancyGrid& grid = map->grid();
  LocalizabilityReport report;
  report.robot = params.robot;
  report.way_limit_m = params.way_m;
  report.features = map->features().size();
  report.free_area_m2 = grid.resolution * grid.resolution *
                        static_cast<double>(std::ranges::count(grid.cells, Cell::kFree));
  const SimulatedLidar lidar(grid);
  const Lattice lattice = make_lattice(lidar, params);
  report.lattice_m = lattice.spacing_m;
  const auto all = static_cast<double>(lattice.positions_map.size());
  for (const Point2& position : lattice.positions_map) {
    if (progress && !progress(static_cast<double>(report.places.size()) / all)) return std::nullopt;
    report.places.push_back(assess_place(map, lidar, position, params));
  }
  report.look_alikes = find_look_alikes(report);
  return report;
}

std::vector<AssessedStart> assess_starts(const LocalizationMapPtr& map,
                                         std::span<const Pose2> T_map_base_link,
                                         const LocalizabilityParams& params) {
  const SimulatedLidar lidar(map->grid());
  std::vector<AssessedStart> starts;
  starts.reserve(T_map_base_link.size());
  for (const Pose2& start : T_map_base_link)
    starts.push_back(assess_start(map, lidar, start, params));
  return starts;
}

}  // namespace cornerfix
