/// \file  A fleet on one server: `cornerfix_load_bench`, or `--url` for a server that runs already.
///
/// Starts `cornerfix serve` on a fresh database, maps Willow Garage by a simulated run, and starts
/// robots one after the other. Each keeps a connection of its own. Each posts a scan of 1080 beams
/// five times per second on a fixed schedule, whether or not the answers come in time. A robot
/// misses when an answer is an error or comes after its next scan is due. Latency counts from when
/// a scan was due. Exit code 1 when a robot has missed once all are on and the last of them has had
/// two seconds to search the map.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <cornerfix/map_image.hpp>

#include "bench/server_process.hpp"
#include "clients/cpp/http_client.hpp"
#include "clients/cpp/scan_json.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/simulation/run_simulator.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::client {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
using Milliseconds = std::chrono::duration<double, std::milli>;

constexpr std::size_t kBeams = 1080;
constexpr std::size_t kMappingBatch = 50;
constexpr std::chrono::seconds kSettling{2};  ///< The last ones to come search the map meanwhile.
constexpr const char* kMap = "/v1/maps/load-bench";

struct LoadOptions {
  std::string url;
  std::size_t robots = 200;
  double scans_per_s = 5.0;
  double ramp_s = 40.0;
  double seconds = 20.0;
  std::string method = "indexed";
};

[[noreturn]] void give_up(const std::string& message) {
  std::fprintf(stderr, "cornerfix_load_bench: %s\n", message.c_str());
  std::exit(2);
}

template <typename T>
T value_of(Result<T> result) {
  if (!result) give_up(result.error().field + ": " + result.error().message);
  return std::move(*result);
}

evaluation::RecordedLog simulated(const evaluation::RunOptions& options) {
  static const OccupancyGrid willow = value_of(read_map_files(CORNERFIX_WILLOW_MAP));
  return value_of(evaluation::simulate_run(willow, options));
}

void make_map(HttpClient& client) {
  const evaluation::RecordedLog log =
      simulated({.beams = kBeams, .drift = 0.0, .length_m = 600.0, .step_m = 0.3, .seed = 1});
  const nlohmann::ordered_json lidar = lidar_json(log.header);
  value_of(client.send({"PUT", kMap, nlohmann::ordered_json{{"lidar", lidar}}.dump()}));
  for (std::size_t at = 0; at < log.scans.size(); at += kMappingBatch) {
    auto scans = nlohmann::ordered_json::array();
    for (std::size_t i = at; i < std::min(at + kMappingBatch, log.scans.size()); ++i) {
      scans.push_back(posed_scan_json(log.header, log.scans[i]));
    }
    value_of(client.send({"POST", std::string(kMap) + "/scans",
                          nlohmann::ordered_json{{"lidar", lidar}, {"scans", scans}}.dump()}));
  }
  value_of(client.send({"GET", std::string(kMap) + "/features"}));  // Makes it ready.
}

/// A run; each robot drives a part of its own.
struct FleetRun {
  nlohmann::ordered_json lidar;
  std::vector<std::string> scans;  ///< As a session takes them.
};

FleetRun fleet_run(std::size_t scans) {
  constexpr double kStep = 0.08;
  const evaluation::RecordedLog log = simulated({.beams = kBeams,
                                                 .people = 3,
                                                 .length_m = kStep * static_cast<double>(scans),
                                                 .step_m = kStep,
                                                 .seed = 2});
  FleetRun fleet{lidar_json(log.header), {}};
  for (const evaluation::LogScan& scan : log.scans)
    fleet.scans.push_back(robot_scan_json(log.header, scan, true).dump());
  return fleet;
}

/// What happened to some scans.
struct Tally {
  std::vector<double> latencies_ms;
  std::size_t errors = 0;
  std::size_t late = 0;
  std::size_t localized = 0;

  void add(const Tally& other) {
    latencies_ms.insert(latencies_ms.end(), other.latencies_ms.begin(), other.latencies_ms.end());
    errors += other.errors;
    late += other.late;
    localized += other.localized;
  }
};

struct Robot {
  Tally while_ramping;
  Tally steady;
};

struct Schedule {
  Clock::time_point begin;   ///< Of this robot's first scan.
  Clock::time_point steady;  ///< All robots are on.
  Clock::time_point end;
  Clock::duration period;
};

std::string open_session(HttpClient& client, const FleetRun& fleet, std::size_t number,
                         const LoadOptions& options) {
  const nlohmann::ordered_json body = {{"robot", "load-" + std::to_string(number)},
                                       {"map", "load-bench"},
                                       {"lidar", fleet.lidar},
                                       {"options", {{"method", options.method}}}};
  const auto answer = value_of(client.send({"POST", "/v1/sessions", body.dump(), true}));
  return nlohmann::json::parse(answer).at("id");
}

/// Leaves its session open: closing it is work that the other robots would have to wait for.
Robot run_robot(const LoadOptions& options, const FleetRun& fleet, std::size_t number,
                std::size_t first_scan, const Schedule& schedule) {
  Robot robot;
  std::this_thread::sleep_until(schedule.begin);
  HttpClient client = value_of(HttpClient::create({.url = options.url, .token = {}}));
  const std::string session = "/v1/sessions/" + open_session(client, fleet, number, options);
  Clock::time_point due = schedule.begin;
  for (std::size_t sequence = 0; due < schedule.end; ++sequence, due += schedule.period) {
    std::this_thread::sleep_until(due);
    const auto answer = client.send({"POST", session + "/scans",
                                     "{\"sequence\":" + std::to_string(sequence) + ",\"scans\":[" +
                                         fleet.scans.at(first_scan + sequence) + "]}"});
    const Clock::duration latency = Clock::now() - due;
    Tally& tally = due < schedule.steady ? robot.while_ramping : robot.steady;
    tally.latencies_ms.push_back(Milliseconds(latency).count());
    tally.errors += answer ? 0 : 1;
    tally.late += latency > schedule.period ? 1 : 0;
    tally.localized += answer && answer->find("\"localized\"") != std::string::npos ? 1 : 0;
  }
  return robot;
}

void print(const char* name, const Tally& tally) {
  using evaluation::percentile;
  std::printf("%-10s %8zu %7zu %6zu %9.1f %9.1f %9.1f %9.1f %9.1f\n", name,
              tally.latencies_ms.size(), tally.errors, tally.late,
              100.0 * static_cast<double>(tally.localized) /
                  static_cast<double>(std::max<std::size_t>(1, tally.latencies_ms.size())),
              percentile(tally.latencies_ms, 0.50), percentile(tally.latencies_ms, 0.95),
              percentile(tally.latencies_ms, 0.99), percentile(tally.latencies_ms, 1.0));
}

struct FleetReport {
  Robot all;                  ///< The tallies of all robots together.
  double processor_ms = 0.0;  ///< Of the server while all were on.
};

FleetReport run_fleet(const LoadOptions& options, const FleetRun& fleet, std::size_t scans_a_robot,
                      const bench::ServerProcess* server) {
  const auto period = std::chrono::duration_cast<Clock::duration>(Seconds(1 / options.scans_per_s));
  const auto ramp = std::chrono::duration_cast<Clock::duration>(Seconds(options.ramp_s));
  const auto start = Clock::now();
  const auto steady = start + ramp + period + kSettling;
  const auto end = steady + std::chrono::duration_cast<Clock::duration>(Seconds(options.seconds));
  std::vector<Robot> robots(options.robots);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    // Spread over the ramp, and over a period at least.
    const auto begin = start + (ramp + period) * i / robots.size();
    const std::size_t first = i * (fleet.scans.size() - scans_a_robot) / robots.size();
    threads.emplace_back([&, i, first, begin] {
      robots[i] = run_robot(options, fleet, i, first, {begin, steady, end, period});
    });
  }
  std::this_thread::sleep_until(steady);
  const double before_ms = server != nullptr ? server->processor_ms() : 0.0;
  FleetReport report;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    threads[i].join();
    report.all.while_ramping.add(robots[i].while_ramping);
    report.all.steady.add(robots[i].steady);
  }
  if (server != nullptr) report.processor_ms = server->processor_ms() - before_ms;
  return report;
}

int run(LoadOptions options) {
  const testing::TemporaryDirectory directory;
  std::optional<bench::ServerProcess> server;
  if (options.url.empty()) options.url = server.emplace(directory / "load.db").url();
  const auto tell_memory = [&](const char* when) {
    if (server) std::printf("server %s: %.1f MB resident\n", when, server->resident_mb());
  };
  HttpClient client = value_of(HttpClient::create({.url = options.url, .token = {}}));
  value_of(client.send({"GET", "/healthz"}));
  tell_memory("idle");
  make_map(client);
  tell_memory("with the map");
  const auto scans_a_robot =
      static_cast<std::size_t>((options.ramp_s + Seconds(kSettling).count() + options.seconds) *
                               options.scans_per_s) +
      4;
  const FleetRun fleet = fleet_run(scans_a_robot + 10 * options.robots);
  const auto [all, processor_ms] =
      run_fleet(options, fleet, scans_a_robot, server ? &*server : nullptr);
  tell_memory("with the fleet");
  if (server) {
    std::printf("server: %.2f ms of processor time a scan while all are on\n",
                processor_ms / static_cast<double>(all.steady.latencies_ms.size()));
  }
  std::printf("%-10s %8s %7s %6s %9s %9s %9s %9s %9s\n", "robots", "scans", "errors", "late",
              "found %", "p50 ms", "p95 ms", "p99 ms", "max ms");
  print("coming", all.while_ramping);
  print("all on", all.steady);
  return all.steady.errors + all.steady.late == 0 ? 0 : 1;
}

}  // namespace
}  // namespace cornerfix::client

int main(int argc, char** argv) {
  cornerfix::client::LoadOptions options;
  CLI::App app("Drives a fleet of robots against a Cornerfix server and counts who had to wait.");
  app.add_option("--url", options.url, "A running server, instead of one started for this");
  app.add_option("--robots", options.robots)->capture_default_str();
  app.add_option("--rate", options.scans_per_s, "Scans a second and robot")->capture_default_str();
  app.add_option("--ramp", options.ramp_s, "Seconds until all robots are on")
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "That all of them are on")->capture_default_str();
  app.add_option("--method", options.method, "indexed, rma or nma")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return cornerfix::client::run(options);
}
