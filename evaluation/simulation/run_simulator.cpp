#include "evaluation/simulation/run_simulator.hpp"

#include <cornerfix/occupancy_grid.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "evaluation/simulation/run_planner.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kRangeMin = 0.05;      ///< [m]
constexpr double kScanPeriod = 0.1;     ///< [s]
constexpr double kLatestStart = 1e10;   ///< [s]; a log writes milliseconds of it exactly
constexpr double kDropoutRate = 0.005;  ///< Beams that come back empty for no reason.
constexpr double kBoxToPath = 0.6;      ///< [m] a box stays off the path.
constexpr int kBoxTries = 50;           ///< A narrow building may have no room for a box.
constexpr double kCrowdRadius = 8.0;    ///< [m] people who got farther away come back.
constexpr double kPersonalSpace = 0.5;  ///< [m] nobody stands nearer to the lidar.
constexpr double kLegRadius = 0.08;     ///< [m]
constexpr double kHalfStride = 0.1;     ///< [m]
constexpr double kWalkPerScan = 0.06;   ///< [m] standard deviation along each axis.
constexpr double kTurnRate = 0.02;

/// Independent random numbers for each cause, from the one seed.
enum class Cause : std::uint32_t { kPath, kOdometry, kRanges, kPeople, kBoxes };

class Random {
 public:
  Random(std::uint64_t seed, Cause cause) {
    std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                           static_cast<std::uint32_t>(cause)};
    engine_.seed(sequence);
  }

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  double normal(double deviation) { return deviation * normal_(engine_); }
  std::size_t index(std::size_t size) {
    return std::uniform_int_distribution<std::size_t>(0, size - 1)(engine_);
  }
  std::uint64_t seed() { return engine_(); }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

/// Wheel odometry: a lasting error of scale and of heading, and a random one, in proportion.
class Odometry {
 public:
  Odometry(double drift, std::uint64_t seed)
      : drift_(drift),
        random_(seed, Cause::kOdometry),
        scale_(1.0 + random_.normal(0.75 * drift)),
        turn_per_metre_(random_.normal(0.2 * drift)) {}

  Pose2 move(const Pose2& T_map_laser) {
    const Pose2 motion = last_ ? inverse(*last_) * T_map_laser : Pose2{};
    last_ = T_map_laser;
    const double length = std::hypot(motion.x, motion.y);
    const Pose2 measured{
        motion.x * scale_ + random_.normal(drift_ * length),
        motion.y + random_.normal(0.5 * drift_ * length),
        motion.yaw * (1.0 + random_.normal(drift_)) + turn_per_metre_ * length +
            random_.normal(0.1 * drift_ * length),
    };
    T_odom_laser_ = T_odom_laser_ * measured;
    return T_odom_laser_;
  }

 private:
  double drift_;
  Random random_;
  double scale_;
  double turn_per_metre_;  ///< [rad/m]
  std::optional<Pose2> last_;
  Pose2 T_odom_laser_;
};

/// People who walk about the robot, each two legs at the lidar's height.
class Crowd {
 public:
  Crowd(int count, const std::vector<Pose2>& path, std::uint64_t seed)
      : random_(seed, Cause::kPeople) {
    for (int i = 0; i < count; ++i) {
      people_.push_back({path[random_.index(path.size())].translation(), new_step()});
    }
  }

  void walk(const Point2& robot) {
    for (Person& person : people_) {
      if ((person.position - robot).norm() > kCrowdRadius) {
        const double bearing = random_.uniform(-std::numbers::pi, std::numbers::pi);
        person.position = robot + 0.5 * kCrowdRadius * Point2{std::cos(bearing), std::sin(bearing)};
      }
      person.position += person.step;
      if (random_.uniform(0.0, 1.0) < kTurnRate) person.step = new_step();
    }
  }

  /// Shortens the beams that legs hide.
  void hide_from(const Pose2& T_map_laser, LaserScan& scan) const {
    for (const Person& person : people_) {
      if ((person.position - T_map_laser.translation()).norm() < kPersonalSpace) continue;
      for (const double side : {-kHalfStride, kHalfStride}) {
        hide_leg(inverse(T_map_laser) * Point2(person.position + Point2{side, 0.0}), scan);
      }
    }
  }

 private:
  struct Person {
    Point2 position;  ///< In `map` [m].
    Point2 step;      ///< A scan [m].
  };

  Point2 new_step() {
    const double x = random_.normal(kWalkPerScan);
    return {x, random_.normal(kWalkPerScan)};
  }

  static void hide_leg(const Point2& leg_laser, LaserScan& scan) {
    for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      const double bearing = scan.bearing(beam);
      const double along = leg_laser.dot(Point2{std::cos(bearing), std::sin(bearing)});
      const double off_squared = leg_laser.squaredNorm() - along * along;
      if (along <= 0.0 || off_squared >= kLegRadius * kLegRadius) continue;
      const double range = along - std::sqrt(kLegRadius * kLegRadius - off_squared);
      if (!(static_cast<double>(scan.ranges[beam]) <= range)) {
        scan.ranges[beam] = static_cast<float>(range);
      }
    }
  }

  Random random_;
  std::vector<Person> people_;
};

/// A rectangle along the axes of a grid.
struct Box {
  Point2 low;   ///< [m]
  Point2 high;  ///< [m]

  [[nodiscard]] double distance_to(const Point2& point) const {
    return (point - point.cwiseMax(low).cwiseMin(high)).norm();
  }
};

/// Puts boxes that the map does not know near the path, but not on it.
void add_boxes(OccupancyGrid& grid, int count, const std::vector<Pose2>& path, std::uint64_t seed) {
  Random random(seed, Cause::kBoxes);
  const Pose2 T_grid_map = inverse(grid.T_map_grid);
  std::vector<Point2> path_grid;
  path_grid.reserve(path.size());
  for (const Pose2& pose : path) path_grid.push_back(T_grid_map * pose.translation());

  const auto random_box = [&] {
    const Point2 corner = path_grid[random.index(path_grid.size())];
    const Point2 low{corner.x() + random.normal(1.5), corner.y() + random.normal(1.5)};
    const double width = random.uniform(0.3, 1.0);
    return Box{low, low + Point2{width, random.uniform(0.3, 1.0)}};
  };
  const auto is_clear_of_path = [&](const Box& box) {
    return std::all_of(path_grid.begin(), path_grid.end(),
                       [&](const Point2& point) { return box.distance_to(point) >= kBoxToPath; });
  };
  for (int placed = 0, tries = 0; placed < count && tries < count * kBoxTries; ++tries) {
    const Box box = random_box();
    if (!is_clear_of_path(box)) continue;
    ++placed;
    const CellIndex low = grid.cell_of(box.low);
    const CellIndex high = grid.cell_of(box.high);
    for (int row = low.row; row <= high.row; ++row) {
      for (int column = low.column; column <= high.column; ++column) {
        if (grid.contains({column, row})) {
          grid.cells[grid.offset({column, row})] = Cell::kOccupied;
        }
      }
    }
  }
}

LaserScan lidar_of(const RunOptions& options) {
  LaserScan lidar;
  // A full turn must not look twice where it begins.
  const bool is_full_turn = options.field_of_view_rad > 2.0 * std::numbers::pi - 1e-3;
  const std::size_t gaps = is_full_turn ? options.beams : options.beams - 1;
  lidar.angle_min = -0.5 * options.field_of_view_rad;
  lidar.angle_increment = options.field_of_view_rad / static_cast<double>(gaps);
  lidar.range_min = kRangeMin;
  lidar.range_max = options.range_max_m;
  return lidar;
}

void add_noise(LaserScan& scan, double noise_m, Random& random) {
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    scan.ranges[beam] += static_cast<float>(random.normal(noise_m));
    const bool is_lost = random.uniform(0.0, 1.0) < kDropoutRate;
    if (is_lost || !scan.has_return(beam)) {
      scan.ranges[beam] = std::numeric_limits<float>::quiet_NaN();
    }
  }
}

void corrupt_odometry(RecordedLog& log, OdometryFaultKind kind, std::uint64_t seed) {
  OdometryFault fault(kind, seed);
  for (LogScan& scan : log.scans)
    scan.T_odom_laser = fault.corrupt(scan.scan.stamp, *scan.T_odom_laser);
}

/// Drives along the path and records.
std::vector<LogScan> record(const OccupancyGrid& grid, const std::vector<Pose2>& path,
                            const RunOptions& options,
                            const std::function<void(double)>& on_progress) {
  const RayCaster caster(grid);
  const LaserScan lidar = lidar_of(options);
  Odometry odometry(options.drift, options.seed);
  Crowd crowd(options.people, path, options.seed);
  Random range_random(options.seed, Cause::kRanges);

  std::vector<LogScan> scans;
  scans.reserve(path.size());
  for (const Pose2& T_map_laser : path) {
    LogScan recorded;
    recorded.scan = caster.scan(lidar, options.beams, T_map_laser);
    recorded.scan.stamp = options.start_s + static_cast<double>(scans.size()) * kScanPeriod;
    crowd.walk(T_map_laser.translation());
    crowd.hide_from(T_map_laser, recorded.scan);
    add_noise(recorded.scan, options.range_noise_m, range_random);
    recorded.T_odom_laser = odometry.move(T_map_laser);
    recorded.T_map_laser = T_map_laser;
    scans.push_back(std::move(recorded));
    if (on_progress) {
      on_progress(static_cast<double>(scans.size()) / static_cast<double>(path.size()));
    }
  }
  return scans;
}

}  // namespace

std::optional<Error> validate(const RunOptions& options) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  const auto is_positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  if (!is_positive(options.field_of_view_rad) ||
      options.field_of_view_rad > 2.0 * std::numbers::pi + 1e-6) {
    return broken("field_of_view_rad", "must be above 0 and at most a full turn");
  }
  if (options.beams < 2) return broken("beams", "must be at least 2");
  if (!(options.range_max_m > kRangeMin) || !std::isfinite(options.range_max_m)) {
    return broken("range_max_m", "must be above 0.05 m");
  }
  if (!(options.range_noise_m >= 0.0) || !std::isfinite(options.range_noise_m)) {
    return broken("range_noise_m", "must not be negative");
  }
  if (!(options.drift >= 0.0) || !std::isfinite(options.drift)) {
    return broken("drift", "must not be negative");
  }
  if (options.people < 0) return broken("people", "must not be negative");
  if (options.boxes < 0) return broken("boxes", "must not be negative");
  if (!is_positive(options.length_m)) return broken("length_m", "must be above 0");
  if (!is_positive(options.step_m)) return broken("step_m", "must be above 0");
  if (!(std::abs(options.start_s) <= kLatestStart)) {
    return broken("start_s", "must be within 1e10 s of 0");
  }
  return std::nullopt;
}

Result<RecordedLog> simulate_run(const OccupancyGrid& map, const RunOptions& options,
                                 const OccupancyGrid* inside,
                                 const std::function<void(double)>& on_progress) {
  if (auto error = validate(options)) return *error;
  const OccupancyGrid& real = inside != nullptr ? *inside : map;
  const std::array maps = {&real, &map};
  const Result<std::vector<Pose2>> path =
      plan_run(std::span(maps).first(inside != nullptr ? 2 : 1),
               {.length_m = options.length_m,
                .step_m = options.step_m,
                .seed = Random(options.seed, Cause::kPath).seed()});
  if (!path) return path.error();

  OccupancyGrid furnished = real;
  add_boxes(furnished, options.boxes, *path, options.seed);
  RecordedLog log;
  log.header.lidar = lidar_of(options);
  log.header.beams = options.beams;
  log.scans = record(furnished, *path, options, on_progress);
  if (options.odometry_fault) corrupt_odometry(log, *options.odometry_fault, options.seed);
  return log;
}

std::string describe_run(const std::string& map_name, const RunOptions& options) {
  char text[256];
  std::snprintf(text, sizeof text, "seed %llu, noise %g m, drift %g, people %d, boxes %d",
                static_cast<unsigned long long>(options.seed), options.range_noise_m, options.drift,
                options.people, options.boxes);
  std::string description = "simulated run in " + map_name + ", " + text;
  if (options.odometry_fault)
    description += ", odometry fault " + std::string(to_string(*options.odometry_fault));
  return description;
}

}  // namespace cornerfix::evaluation
