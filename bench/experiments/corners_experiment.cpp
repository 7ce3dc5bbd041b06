/// \file  Section 4.2, tables 1-3, figure 7: corners of a scan by the paper's method, by line
/// intersection and by the paper's baselines, in the paper's room and in random ones.
#include <algorithm>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <cornerfix/corners.hpp>

#include "bench/experiments/csv_file.hpp"
#include "bench/experiments/experiment.hpp"
#include "bench/rivals/loam_corners.hpp"
#include "core/src/features/feature_map.hpp"
#include "core/src/scan/vfp_corners.hpp"
#include "evaluation/metrics/processor_time.hpp"
#include "support/floor_plans.hpp"
#include "support/scan_simulator.hpp"
#ifdef CORNERFIX_BENCH_HAS_EXTERNAL
#include "bench/external/image_corners.hpp"
#endif

namespace cornerfix::bench {
namespace {

using evaluation::thread_ms;

constexpr double kSuppressionRadius = 1.0;  // [m] for all, as in the paper
constexpr double kCornerTolerance = 0.1;    // [m] likewise
constexpr double kSeenArm = 0.6;            // [m] of both walls in sight: must be found

struct CornersArguments {
  std::size_t seeds = 200;
  std::filesystem::path out = ".";
};

using Extract = std::function<std::vector<Feature>(const LaserScan&)>;

struct Method {
  std::string name;
  Extract extract;
};

std::vector<Method> methods() {
  return {
      {"vfp", [](const LaserScan& scan) { return extract_corners(scan, CornerExtractor::kVfp); }},
      {"two_arm",
       [](const LaserScan& scan) {
         return extract_corners(scan, CornerExtractor::kLineIntersection);
       }},
      {"loam",
       [](const LaserScan& scan) {
         return extract_loam_corners(scan, vfp_params_for(scan.angle_increment));
       }},
#ifdef CORNERFIX_BENCH_HAS_EXTERNAL
      {"harris", [](const LaserScan& scan) { return extract_harris_corners(scan, {}); }},
      {"orb", [](const LaserScan& scan) { return extract_orb_corners(scan, {}); }},
#endif
  };
}

/// Where the lidar stands, in which room.
struct Place {
  testing::SceneBuilder scene;
  Pose2 T_map_laser;
};

Place paper_room(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> turn(-std::numbers::pi, std::numbers::pi);
  return {testing::figure7_room(), {7.5, 5.0, turn(random)}};
}

Place random_room(std::uint64_t seed) { return {testing::random_room(seed), {}}; }

struct Counts {
  std::size_t found = 0;        ///< Corners that were found.
  std::size_t found_right = 0;  ///< Of these, near one of the room.
  std::size_t seen = 0;         ///< Corners of the room that must be found.
  std::size_t seen_found = 0;   ///< Of these, with one found near it.
  double extract_ms = 0.0;
  double suppress_ms = 0.0;

  Counts& operator+=(const Counts& other) {
    found += other.found;
    found_right += other.found_right;
    seen += other.seen;
    seen_found += other.seen_found;
    extract_ms += other.extract_ms;
    suppress_ms += other.suppress_ms;
    return *this;
  }
};

bool has_near(const std::vector<Point2>& points, const Point2& point) {
  return std::ranges::any_of(
      points, [&](const Point2& other) { return (other - point).norm() <= kCornerTolerance; });
}

struct Found {
  std::vector<Point2> corners_map;
  double extract_ms = 0.0;
  double suppress_ms = 0.0;
};

Found find(const Method& method, const LaserScan& scan, const Pose2& T_map_laser) {
  const double begin = thread_ms();
  const std::vector<Feature> corners = method.extract(scan);
  const double extracted = thread_ms();
  FeatureMap map({.suppression_radius_m = kSuppressionRadius});
  map.insert(corners);
  Found found{{}, extracted - begin, thread_ms() - extracted};
  for (const Feature& feature : map.features())
    found.corners_map.emplace_back(T_map_laser * feature.position);
  return found;
}

Counts judge(const Found& found, const Place& place) {
  const Point2 origin = place.T_map_laser.translation();
  const std::vector<Point2> all = place.scene.corners();
  const std::vector<Point2> seen = place.scene.corners_seen(origin, kSeenArm);
  Counts counts{.found = found.corners_map.size(),
                .seen = seen.size(),
                .extract_ms = found.extract_ms,
                .suppress_ms = found.suppress_ms};
  for (const Point2& corner : found.corners_map)
    counts.found_right += has_near(all, corner) ? 1 : 0;
  for (const Point2& corner : seen)
    counts.seen_found += has_near(found.corners_map, corner) ? 1 : 0;
  return counts;
}

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

class CornersExperiment {
 public:
  explicit CornersExperiment(const CornersArguments& arguments)
      : arguments_(arguments),
        table_(arguments.out / "corners.csv",
               "room,noise_m,method,rooms,precision,recall,found,extract_ms,suppress_ms"),
        picture_(arguments.out / "corners_picture.csv", "noise_m,kind,x_m,y_m") {}

  void run() {
    for (const double noise : {0.0, 0.03, 0.07}) {
      measure("paper", noise, paper_room);
      measure("random", noise, random_room);
      draw(noise);
    }
  }

 private:
  static LaserScan scan_of(const Place& place, double noise, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    return testing::simulate_scan(place.scene, {.beams = 1440, .noise_m = noise}, place.T_map_laser,
                                  random);
  }

  template <typename MakePlace>
  void measure(const char* room, double noise, const MakePlace& make_place) {
    for (const Method& method : methods()) {
      Counts sum;
      for (std::uint64_t seed = 0; seed < arguments_.seeds; ++seed) {
        const Place place = make_place(seed);
        sum += judge(find(method, scan_of(place, noise, seed), place.T_map_laser), place);
      }
      const auto rooms = static_cast<double>(arguments_.seeds);
      table_.row(room, noise, method.name, arguments_.seeds, ratio(sum.found_right, sum.found),
                 ratio(sum.seen_found, sum.seen), static_cast<double>(sum.found) / rooms,
                 sum.extract_ms / rooms, sum.suppress_ms / rooms);
    }
  }

  /// One scan in the paper's room with what each method finds in it.
  void draw(double noise) {
    const Place place = paper_room(1);
    const LaserScan scan = scan_of(place, noise, 1);
    const auto write = [&](const std::string& kind, const Point2& point) {
      picture_.row(noise, kind, point.x(), point.y());
    };
    write("lidar", place.T_map_laser.translation());
    for (const Point2& point : returns_as_points(scan)) write("scan", place.T_map_laser * point);
    for (const Point2& corner : place.scene.corners_seen(place.T_map_laser.translation(), kSeenArm))
      write("corner", corner);
    for (const Method& method : methods()) {
      for (const Point2& corner : find(method, scan, place.T_map_laser).corners_map)
        write(method.name, corner);
    }
  }

  CornersArguments arguments_;
  CsvFile table_;
  CsvFile picture_;
};

}  // namespace

void add_corners_experiment(CLI::App& app) {
  auto arguments = std::make_shared<CornersArguments>();
  CLI::App* command =
      app.add_subcommand("corners", "Section 4.2: corners of a scan, precision, recall and time");
  command->add_option("--seeds", arguments->seeds, "Scans a room, noise and method")
      ->check(CLI::PositiveNumber);
  add_out_option(*command, arguments->out);
  command->callback([arguments] { CornersExperiment(*arguments).run(); });
}

}  // namespace cornerfix::bench
