/// \file  A robot in any of many maps on one server: `cornerfix_maps_bench`.
///
/// `fill` puts generated storeys of 30 by 20 m into a database, with what the server derives of
/// them. `ask` starts `cornerfix serve` on it and switches robots on, one after the other, spread
/// over the storeys. Each posts a scan of 240 beams per batch until its pose is accepted. A
/// pose is right in the right map within 0.5 m and 5 deg.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <cornerfix/map_sketch.hpp>
#include <cornerfix/mapper.hpp>

#include "bench/server_process.hpp"
#include "clients/cpp/http_client.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/metrics/pose_error.hpp"
#include "storage/database.hpp"
#include "storage/map_store.hpp"
#include "support/simulated_drive.hpp"
#include "support/storeys.hpp"

namespace cornerfix::bench {
namespace {

using Clock = std::chrono::steady_clock;
using evaluation::mean;
using evaluation::percentile;

struct MapsOptions {
  std::string database;
  std::size_t maps = 100;
  std::size_t robots = 100;
  std::size_t first_robot = 0;
  std::size_t scans = 120;
  std::size_t storeys = 0;  ///< Those that robots are in; 0: all maps.
  bool composites = false;
  bool along_corridor = false;
  bool names_map = false;
  bool names_all = false;
  bool is_verbose = false;
};

template <typename T>
T value_of(Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "cornerfix_maps_bench: %s: %s\n", result.error().field.c_str(),
               result.error().message.c_str());
  std::exit(2);
}

void check(const Result<void>& result) {
  if (!result) value_of(Result<int>(result.error()));
}

std::string name_of(std::size_t storey) {
  std::string digits = std::to_string(storey);
  return "storey-" + std::string(6 - std::min<std::size_t>(6, digits.size()), '0') + digits;
}

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// --- fill

struct MadeStorey {
  OccupancyGrid grid;
  MapContent content;
  MapSketch sketch;
};

MadeStorey make_storey(std::size_t seed) {
  constexpr double kResolution = 0.1;  // [m]
  MadeStorey made{
      .grid = testing::random_storey(seed).grid(kResolution), .content = {}, .sketch = {}};
  made.content = value_of(map_from_grid(made.grid, {})).content;
  made.sketch = sketch_of(made.content.features, made.content.grid);
  return made;
}

void store(storage::MapStore& maps, const std::string& name, const MadeStorey& made) {
  const OccupancyGrid& grid = made.grid;
  const Point2 low = grid.T_map_grid.translation();
  const Point2 size(grid.width * grid.resolution, grid.height * grid.resolution);
  const storage::MapInfo info =
      value_of(maps.put_floor_map(name,
                                  {.grid = grid,
                                   .outline = {.feature_count = made.content.features.size(),
                                               .bounds = Bounds{low, low + size}}},
                                  "2026-01-01T00:00:00Z"));
  check(maps.store_content(info.id, info.revision, made.content));
  check(maps.store_sketch(info.id, info.revision, made.sketch));
}

MadeStorey stored_storey(storage::MapStore& maps, std::size_t storey) {
  const storage::MapInfo info = value_of(maps.find(name_of(storey)));
  return {.grid = value_of(maps.floor_map(info.id)),
          .content = value_of(maps.content(info.id)).value().content,
          .sketch = {}};
}

/// The left half of one grid's mirror image, and the right half of another one's of its size.
OccupancyGrid composite(const OccupancyGrid& left, const OccupancyGrid& right) {
  OccupancyGrid made = left;
  for (int row = 0; row < made.height; ++row) {
    for (int column = 0; column < made.width; ++column) {
      const OccupancyGrid& from = column < made.width / 2 ? left : right;
      const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(made.width);
      made.cells[at + static_cast<std::size_t>(column)] = from.at({made.width - 1 - column, row});
    }
  }
  return made;
}

/// Halves of the mirror images of two storeys: a map that no robot is in.
MadeStorey composite(const MadeStorey& left, const MadeStorey& right) {
  MadeStorey made{.grid = composite(left.grid, right.grid), .content = {}, .sketch = {}};
  const OccupancyGrid& grid = left.content.grid;
  made.content.grid = composite(grid, right.content.grid);
  const double width_m = grid.width * grid.resolution;
  const double middle_x = grid.T_map_grid.x + width_m / 2.0;
  for (const MadeStorey* half : {&left, &right}) {
    for (Feature feature : half->content.features) {
      feature.position.x() = 2.0 * middle_x - feature.position.x();
      feature.bisector = wrap_angle(std::numbers::pi - feature.bisector);
      if ((feature.position.x() < middle_x) == (half == &left))
        made.content.features.push_back(feature);
    }
  }
  made.content.descriptors = describe(made.content.features, left.content.descriptors.params);
  made.sketch = sketch_of(made.content.features, made.content.grid);
  return made;
}

/// Storeys up to `maps`, or composites of those that are stored.
void fill(const MapsOptions& options) {
  storage::MapStore maps(
      value_of(storage::Database::open(options.database, storage::Synchronous::kNormal)));
  const std::size_t stored = value_of(maps.count());
  std::atomic<std::size_t> next = stored;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t number = next++; number < options.maps; number = next++) {
      std::unique_lock lock(mutex, std::defer_lock);
      if (!options.composites) {
        const MadeStorey made = make_storey(number);
        lock.lock();
        store(maps, name_of(number), made);
        continue;
      }
      const std::size_t step = 97 * (number / stored);  // Another partner in each round.
      lock.lock();
      const MadeStorey left = stored_storey(maps, number % stored);
      const MadeStorey right = stored_storey(maps, (number + step) % stored);
      lock.unlock();
      const MadeStorey made = composite(left, right);
      lock.lock();
      store(maps, "composite-" + std::to_string(number), made);
    }
  };
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i)
    threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  std::printf("%zu maps\n", value_of(maps.count()));
}

// --- ask

/// One robot, until its pose was accepted or its scans were all posted.
struct Asked {
  bool is_right = false;
  bool is_wrong = false;
  std::size_t scans = 0;
  // Processor time of the server per batch that it searched for [ms]:
  std::vector<double> early;         ///< before six corners were seen,
  std::vector<double> good;          ///< and after it.
  std::vector<double> latencies_ms;  ///< Per batch.
  std::string last_reason;
};

/// From the end of the corridor ahead while there is room, or along the corridor and back.
std::vector<testing::Moment> drive_in(std::size_t seed, const MapsOptions& options) {
  const testing::Storey storey = testing::random_storey(seed);
  const Point2 begin = storey.inside + Point2(1.0, 0.0);
  std::vector<Pose2> poses;
  if (options.along_corridor) {
    const Point2 end(testing::kStoreySize.x() - 1.5, begin.y());
    poses = testing::route(std::vector{begin, end, begin}, 0.25);
    poses.resize(std::min(poses.size(), options.scans));
  } else {
    const double yaw = 0.7 * static_cast<double>(seed % 9);
    poses = testing::wander(storey.scene, {begin.x(), begin.y(), wrap_angle(yaw)}, options.scans);
  }
  return testing::drive(storey.scene, {}, poses, seed + 7);
}

nlohmann::json json_of(const Pose2& pose) {
  return {{"x", pose.x}, {"y", pose.y}, {"yaw", pose.yaw}};
}

std::string batch_of(std::size_t sequence, const RobotScan& scan) {
  return nlohmann::json{{"sequence", sequence},
                        {"scans",
                         {{{"stamp", scan.scan.stamp},
                           {"ranges", scan.scan.ranges},
                           {"odom", json_of(*scan.T_odom_base_link)}}}}}
      .dump();
}

std::string open_session(client::HttpClient& client, std::size_t storey, const LaserScan& scan,
                         const MapsOptions& options) {
  nlohmann::json body{{"robot", name_of(storey)},
                      {"map", nullptr},
                      {"lidar",
                       {{"angle_min", scan.angle_min},
                        {"angle_increment", scan.angle_increment},
                        {"range_min", scan.range_min},
                        {"range_max", scan.range_max}}}};
  if (options.names_map) body["map"] = name_of(storey);
  for (std::size_t i = 0; options.names_all && i < options.maps; ++i)
    body["maps"].push_back(name_of(i));
  const auto answer = value_of(client.send({"POST", "/v1/sessions", body.dump(), true}));
  return nlohmann::json::parse(answer).at("id");
}

Asked ask_one(client::HttpClient& client, const ServerProcess& server, std::size_t storey,
              const MapsOptions& options) {
  const std::vector<testing::Moment> moments = drive_in(storey, options);
  const std::string session =
      "/v1/sessions/" + open_session(client, storey, moments.front().scan.scan, options);
  Asked asked;
  for (const testing::Moment& moment : moments) {
    const std::string body = batch_of(asked.scans++, moment.scan);
    const Clock::time_point begin = Clock::now();
    const double before_ms = server.processor_ms();
    const auto answer =
        nlohmann::json::parse(value_of(client.send({"POST", session + "/scans", body})));
    const double latency_ms = ms_since(begin);
    const double processor_ms = server.processor_ms() - before_ms;
    constexpr int kEnoughCorners = 6;
    const bool is_good = answer["local"]["features"] >= kEnoughCorners;
    const auto& times = answer["timing_ms"];
    const double ms = times["match"].get<double>() + times["verify"].get<double>();
    constexpr double kSearched = 0.5;  // [ms]
    if (ms > kSearched) (is_good ? asked.good : asked.early).push_back(processor_ms);
    asked.latencies_ms.push_back(latency_ms);
    asked.last_reason = answer["reason"].is_null() ? answer["status"] : answer["reason"];
    if (answer["status"] != "localized") continue;
    const auto& pose = answer["pose"];
    const bool is_right = pose["map"] == name_of(storey) &&
                          evaluation::is_correct(evaluation::pose_error(
                              {pose["x"], pose["y"], pose["yaw"]}, moment.T_map_base_link));
    (is_right ? asked.is_right : asked.is_wrong) = true;
    break;
  }
  value_of(client.send({"DELETE", session, "", true}));
  return asked;
}

void print(const char* what, const std::vector<double>& ms) {
  std::printf("ms %s: mean %.1f, p50 %.1f, p95 %.1f, max %.1f (%zu)\n", what, mean(ms),
              percentile(ms, 0.5), percentile(ms, 0.95), percentile(ms, 1.0), ms.size());
}

void ask(const MapsOptions& options) {
  const Clock::time_point begin = Clock::now();
  const ServerProcess server(options.database);
  std::printf("start: %.2f s, %.1f MB resident\n", ms_since(begin) / 1e3, server.resident_mb());
  std::fflush(stdout);
  client::HttpClient client =
      value_of(client::HttpClient::create({.url = server.url(), .token = {}}));
  Asked all;
  std::vector<double> scans;
  std::size_t right = 0;
  std::size_t wrong = 0;
  for (std::size_t i = options.first_robot; i < options.robots; ++i) {
    const std::size_t storeys = options.storeys > 0 ? options.storeys : options.maps;
    const std::size_t storey = i * storeys / options.robots;
    const Asked asked = ask_one(client, server, storey, options);
    right += asked.is_right ? 1 : 0;
    wrong += asked.is_wrong ? 1 : 0;
    if (asked.is_right) scans.push_back(static_cast<double>(asked.scans));
    all.early.insert(all.early.end(), asked.early.begin(), asked.early.end());
    all.good.insert(all.good.end(), asked.good.begin(), asked.good.end());
    all.latencies_ms.insert(all.latencies_ms.end(), asked.latencies_ms.begin(),
                            asked.latencies_ms.end());
    if (options.is_verbose) {
      std::printf("%zu: %s after %zu scans, %s\n", storey,
                  asked.is_right   ? "right"
                  : asked.is_wrong ? "wrong"
                                   : "none",
                  asked.scans, asked.last_reason.c_str());
      std::fflush(stdout);
    }
  }
  std::printf("robots %zu, right %zu, wrong %zu, scans p50 %.0f p90 %.0f\n",
              options.robots - options.first_robot, right, wrong, percentile(scans, 0.5),
              percentile(scans, 0.9));
  print("of processor time per search with few corners", all.early);
  print("of processor time per search with six corners", all.good);
  print("per batch", all.latencies_ms);
  std::printf("end: %.1f MB resident, %.1f s of processor time\n", server.resident_mb(),
              server.processor_ms() / 1e3);
}

}  // namespace
}  // namespace cornerfix::bench

int main(int argc, char** argv) {
  using namespace cornerfix::bench;
  MapsOptions options;
  CLI::App app("Measures a server with many generated maps.");
  app.require_subcommand(1);
  app.option_defaults()->always_capture_default();
  CLI::App* filling = app.add_subcommand("fill", "Puts generated maps into a database");
  CLI::App* asking = app.add_subcommand("ask", "Switches robots on in a filled database");
  for (CLI::App* command : {filling, asking}) {
    command->add_option("--db", options.database, "File or URL")->required();
    command->add_option("--maps", options.maps, "That the database has then")
        ->check(CLI::PositiveNumber);
  }
  asking->add_option("--robots", options.robots, "Spread over the maps")
      ->check(CLI::PositiveNumber);
  asking->add_option("--first", options.first_robot, "Number of the first robot");
  asking->add_option("--scans", options.scans, "At most, per robot")->check(CLI::PositiveNumber);
  asking->add_option("--storeys", options.storeys, "That robots are in; 0: all maps");
  asking->add_flag("--corridor", options.along_corridor, "Robots drive along the corridor");
  filling->add_flag("--composites", options.composites,
                    "Adds maps of halves of mirrored storeys that are there");
  asking->add_flag("--named", options.names_map, "Robots name their map: the cost of one map");
  asking->add_flag("--unranked", options.names_all, "Robots name all maps: no ranking");
  asking->add_flag("--verbose", options.is_verbose, "A line per robot");
  filling->callback([&] { fill(options); });
  asking->callback([&] { ask(options); });
  CLI11_PARSE(app, argc, argv);
  return 0;
}
