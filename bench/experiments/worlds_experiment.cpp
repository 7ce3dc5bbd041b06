/// \file  Section 4.4, figures 9-11: robots in a static, in a changed and in a repetitive world of
/// 25 by 25 m, with the paper's lidar.
#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/corner_extractor.hpp>

#include "bench/experiments/contestants.hpp"
#include "bench/experiments/csv_file.hpp"
#include "bench/experiments/experiment.hpp"
#include "support/map_maker.hpp"

namespace cornerfix::bench {
namespace {

constexpr double kSide = 25.0;  // [m]
const Point2 kStart(12.5, 12.5);

struct WorldsArguments {
  std::size_t worlds = 20;
  std::vector<std::string> methods = {"cornerfix", "rma_published"};
  std::filesystem::path out = ".";
};

using testing::SceneBuilder;

/// Boxes anywhere but near the start, at least `clear_m` off it and `reach_m` at most.
void add_boxes(SceneBuilder& scene, int count, double clear_m, double reach_m,
               std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0), size(0.4, 2.0), turn(-1.5, 1.5);
  for (int placed = 0; placed < count;) {
    const Point2 center = kSide * Point2(share(random), share(random));
    const double distance_m = (center - kStart).norm();
    if (distance_m < clear_m || distance_m > reach_m) continue;
    scene.box(center, {size(random), size(random)}, turn(random));
    ++placed;
  }
}

/// A hall with inner walls and boxes, none like another.
SceneBuilder static_world(std::mt19937_64& random) {
  SceneBuilder scene = SceneBuilder()
                           .room({0, 0}, {kSide, kSide})
                           .wall({8, 0}, {8, 6})
                           .wall({0, 16}, {6, 16})
                           .wall({17, 25}, {17, 18})
                           .wall({25, 9}, {19, 9});
  add_boxes(scene, 14, 2.5, kSide, random);
  return scene;
}

/// Four quarters with the same boxes, and a few that only one has, far from the start.
SceneBuilder similar_world(std::mt19937_64& random) {
  SceneBuilder scene = SceneBuilder().room({0, 0}, {kSide, kSide});
  std::uniform_real_distribution<double> at(1.5, 9.5), size(0.5, 1.5), turn(-1.5, 1.5);
  for (int i = 0; i < 5; ++i) {
    const Point2 center(at(random), at(random));
    const Point2 extent(size(random), size(random));
    const double yaw = turn(random);
    for (const double x : {0.0, kSide / 2.0}) {
      for (const double y : {0.0, kSide / 2.0}) scene.box(center + Point2(x, y), extent, yaw);
    }
  }
  add_boxes(scene, 3, 8.0, kSide, random);
  return scene;
}

struct World {
  SceneBuilder mapped;
  SceneBuilder now;
};

World make_world(const std::string& kind, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  World world;
  world.mapped = kind == "similar" ? similar_world(random) : static_world(random);
  world.now = world.mapped;
  if (kind == "changed") add_boxes(world.now, 12, 1.2, 5.0, random);
  return world;
}

/// Once round on the spot, as in the paper, then about the world.
std::vector<Pose2> way_through(const SceneBuilder& scene, double yaw) {
  std::vector<Pose2> poses;
  constexpr int kTurns = 36;
  for (int i = 0; i < kTurns; ++i) {
    poses.push_back(
        {kStart.x(), kStart.y(), wrap_angle(yaw + i * 2.0 * std::numbers::pi / kTurns)});
  }
  const auto onward = testing::wander(scene, {kStart.x(), kStart.y(), wrap_angle(yaw)}, 120);
  poses.insert(poses.end(), onward.begin(), onward.end());
  return poses;
}

cli::RecordedLog record(const std::string& name, const std::vector<testing::Moment>& moments) {
  cli::RecordedLog log;
  log.header.name = name;
  for (const testing::Moment& moment : moments) {
    log.scans.push_back(
        {moment.scan.scan, moment.scan.T_odom_base_link, moment.T_map_base_link, false});
  }
  return log;
}

class WorldsExperiment {
 public:
  explicit WorldsExperiment(const WorldsArguments& arguments)
      : arguments_(arguments),
        table_(arguments.out / "worlds.csv",
               "world,seed,method,verdict,way_m,seconds,error_m,error_rad,corners_seen,x_m,y_m"),
        walls_(arguments.out / "worlds_walls.csv", "world,kind,x0_m,y0_m,x1_m,y1_m") {}

  void run() {
    for (const char* kind : {"static", "changed", "similar"}) {
      draw(kind);
      for (std::uint64_t seed = 0; seed < arguments_.worlds; ++seed) run(kind, seed);
    }
  }

 private:
  void run(const std::string& kind, std::uint64_t seed) {
    const World world = make_world(kind, seed);
    const MappedBuilding building =
        map_building(kind, testing::mapping_scans(world.mapped, kStart));
    const testing::Robot robot{
        .lidar = {.beams = 721, .field_of_view_rad = std::numbers::pi, .noise_m = 0.01},
        .odometry_scale = 1.01};
    const double yaw = static_cast<double>(seed);
    const cli::RecordedLog log =
        record(kind, testing::drive(world.now, robot, way_through(world.now, yaw), seed));
    const std::size_t corners =
        extract_corners(log.scans.front().scan, CornerExtractor::kTwoArm).size();
    for (const std::string& method : arguments_.methods) {
      const Contestant contestant = make_contestant(method, building);
      ScanTimes times;
      cli::EvaluationOptions options;
      options.starts = 1;
      options.batch = 1;
      options.track_m = 0.0;
      options.make_robot = [&](const cli::LogScan& first) {
        return contestant.switch_on(first, times);
      };
      const auto records = cli::evaluate(log, 0, {building.map}, 0, {kStart}, options, nullptr);
      write(kind, seed, method, records.front(), corners);
    }
  }

  void write(const std::string& kind, std::uint64_t seed, const std::string& method,
             const cli::StartRecord& record, std::size_t corners) {
    if (record.verdict == cli::Verdict::kNone) {
      table_.row(kind, seed, method, "none", "", "", "", "", corners, "", "");
      return;
    }
    table_.row(kind, seed, method, record.verdict == cli::Verdict::kFixed ? "fixed" : "wrong",
               *record.way_m, *record.seconds, record.error_m, record.error_rad, corners,
               record.truth.x, record.truth.y);
  }

  /// The first world of a kind, for a figure.
  void draw(const std::string& kind) {
    const World world = make_world(kind, 0);
    const std::size_t mapped = world.mapped.walls().size();
    for (std::size_t i = 0; i < world.now.walls().size(); ++i) {
      const testing::Wall& wall = world.now.walls()[i];
      walls_.row(kind, i < mapped ? "mapped" : "added", wall.a.x(), wall.a.y(), wall.b.x(),
                 wall.b.y());
    }
  }

  WorldsArguments arguments_;
  CsvFile table_;
  CsvFile walls_;
};

}  // namespace

void add_worlds_experiment(CLI::App& app) {
  auto arguments = std::make_shared<WorldsArguments>();
  CLI::App* command = app.add_subcommand(
      "worlds", "Section 4.4: a static, a changed and a repetitive world of 25 by 25 m");
  command->add_option("--worlds", arguments->worlds, "Of each kind")->check(CLI::PositiveNumber);
  command->add_option("--methods", arguments->methods, "Which ones")
      ->delimiter(',')
      ->check(CLI::IsMember(contestant_names()));
  add_out_option(*command, arguments->out);
  command->callback([arguments] { WorldsExperiment(*arguments).run(); });
}

}  // namespace cornerfix::bench
