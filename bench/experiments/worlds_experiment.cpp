/// \file  Section 4.4, figures 9-11: robots in a static, in a changed and in a repetitive world of
/// 25 by 25 m, with the paper's lidar.
#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/corners.hpp>

#include "bench/experiments/contestants.hpp"
#include "bench/experiments/csv_file.hpp"
#include "bench/experiments/experiment.hpp"
#include "support/map_maker.hpp"

namespace cornerfix::bench {
namespace {

constexpr double kSquareSide = 25.0;  // [m]

struct WorldsArguments {
  std::size_t worlds = 20;
  std::vector<std::string> methods = {"cornerfix", "rma_published"};
  std::filesystem::path out = ".";
};

using testing::SceneBuilder;

/// Boxes anywhere in the world at least `clear_m` off the start and `reach_m` at most.
void add_boxes(SceneBuilder& scene, const Point2& start, int count, double clear_m, double reach_m,
               std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0), size(0.4, 2.0), turn(-1.5, 1.5);
  for (int placed = 0; placed < count;) {
    const Point2 center = kSquareSide * Point2(share(random), share(random));
    const double distance_m = (center - start).norm();
    if (distance_m < clear_m || distance_m > reach_m) continue;
    scene.box(center, {size(random), size(random)}, turn(random));
    ++placed;
  }
}

struct World {
  SceneBuilder mapped;
  SceneBuilder now;
  Point2 start;
};

/// A hall with inner walls and boxes, none like another.
World static_world(std::mt19937_64& random) {
  World world{SceneBuilder()
                  .room({0, 0}, {kSquareSide, kSquareSide})
                  .wall({8, 0}, {8, 6})
                  .wall({0, 16}, {6, 16})
                  .wall({17, 25}, {17, 18})
                  .wall({25, 9}, {19, 9}),
              {},
              {kSquareSide / 2.0, kSquareSide / 2.0}};
  add_boxes(world.mapped, world.start, 14, 2.5, kSquareSide, random);
  world.now = world.mapped;
  return world;
}

World changed_world(std::mt19937_64& random) {
  World world = static_world(random);
  add_boxes(world.now, world.start, 12, 1.2, 5.0, random);
  return world;
}

/// Four rooms with the same boxes that open into each other; three more boxes lie in other rooms
/// than the start.
World similar_world(std::mt19937_64& random) {
  constexpr double kRoom = kSquareSide / 2.0;
  constexpr double kDoor = 1.6;
  World world{
      SceneBuilder().room({0, 0}, {kSquareSide, kSquareSide}), {}, {kRoom / 2.0, kRoom / 2.0}};
  const double doors[] = {kRoom / 2.0, 1.5 * kRoom};
  double begin = 0.0;
  for (const double door : {doors[0], doors[1], kSquareSide + kDoor / 2.0}) {
    world.mapped.wall({kRoom, begin}, {kRoom, door - kDoor / 2.0});
    world.mapped.wall({begin, kRoom}, {door - kDoor / 2.0, kRoom});
    begin = door + kDoor / 2.0;
  }
  SceneBuilder boxes;
  add_boxes(boxes, world.start, 3, 2.0, 4.5, random);
  for (const double x : {0.0, kRoom}) {
    for (const double y : {0.0, kRoom}) {
      const SceneBuilder moved = boxes.moved({x, y, 0.0});
      for (const testing::Wall& wall : moved.walls()) world.mapped.wall(wall.a, wall.b);
    }
  }
  add_boxes(world.mapped, world.start, 3, 10.0, kSquareSide, random);
  world.now = world.mapped;
  return world;
}

World make_world(const std::string& kind, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  if (kind == "static") return static_world(random);
  return kind == "changed" ? changed_world(random) : similar_world(random);
}

/// Once round on the spot, as in the paper, then about the world.
std::vector<Pose2> way_through(const World& world, double yaw) {
  std::vector<Pose2> poses;
  constexpr int kTurns = 36;
  for (int i = 0; i < kTurns; ++i) {
    poses.push_back(
        {world.start.x(), world.start.y(), wrap_angle(yaw + i * 2.0 * std::numbers::pi / kTurns)});
  }
  const auto onward =
      testing::wander(world.now, {world.start.x(), world.start.y(), wrap_angle(yaw)}, 120);
  poses.insert(poses.end(), onward.begin(), onward.end());
  return poses;
}

evaluation::RecordedLog record(const std::string& name,
                               const std::vector<testing::Moment>& moments) {
  evaluation::RecordedLog log;
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
    const auto mapping = testing::mapping_scans(world.mapped, world.start);
    const MappedBuilding building = map_building(kind, mapping, mapping);
    const testing::Robot robot{
        .lidar = {.beams = 721, .field_of_view_rad = std::numbers::pi, .noise_m = 0.01},
        .odometry_scale = 1.01};
    const double yaw = static_cast<double>(seed);
    const evaluation::RecordedLog log =
        record(kind, testing::drive(world.now, robot, way_through(world, yaw), seed));
    const std::size_t corners =
        extract_corners(log.scans.front().scan, CornerExtractor::kLineIntersection).size();
    for (const std::string& method : arguments_.methods) {
      const Contestant contestant = make_contestant(method, building);
      ScanTimes times;
      evaluation::EvaluationOptions options;
      options.starts = 1;
      options.batch = 1;
      options.track_m = 0.0;
      options.make_robot = [&](const evaluation::LogScan& first) {
        return contestant.switch_on(first, times);
      };
      const auto records =
          evaluation::evaluate(log, 0, {building.map}, 0, {world.start}, options, nullptr);
      write(kind, seed, method, records.front(), corners);
    }
  }

  void write(const std::string& kind, std::uint64_t seed, const std::string& method,
             const evaluation::StartRecord& record, std::size_t corners) {
    if (record.verdict == evaluation::Verdict::kNone) {
      table_.row(kind, seed, method, "none", "", "", "", "", corners, "", "");
      return;
    }
    table_.row(kind, seed, method,
               record.verdict == evaluation::Verdict::kCorrect ? "fixed" : "wrong",
               *record.localized_after_m, *record.localized_after_s, record.error_m,
               record.error_rad, corners, record.truth.x, record.truth.y);
  }

  /// The first world of a kind, for a figure; the start is a wall without length.
  void draw(const std::string& kind) {
    const World world = make_world(kind, 0);
    walls_.row(kind, "start", world.start.x(), world.start.y(), world.start.x(), world.start.y());
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
