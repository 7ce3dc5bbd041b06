#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/command.hpp"
#include "cli/server_connection.hpp"
#include "cli/table.hpp"
#include "cli/whole_log.hpp"
#include "clients/cpp/fleet_load.hpp"
#include "evaluation/metrics/percentile.hpp"

namespace cornerfix::cli {

namespace {

struct LoadArguments {
  client::FleetOptions fleet;
  std::string log;
  evaluation::LogSelection selection;
  bool json = false;
};

constexpr double kPercentiles[] = {0.5, 0.95, 0.99, 1.0};
constexpr const char* kPercentileNames[] = {"p50", "p95", "p99", "max"};

double latency_ms(const client::BatchTally& tally, double share) {
  return tally.latencies_ms.empty() ? 0.0 : evaluation::percentile(tally.latencies_ms, share);
}

nlohmann::ordered_json json_of(const client::BatchTally& tally) {
  nlohmann::ordered_json json = {{"offered", tally.offered}, {"served", tally.served},
                                 {"late", tally.late},       {"shed", tally.shed},
                                 {"failed", tally.failed},   {"localized", tally.localized}};
  auto& latency = json["latency_ms"] = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < std::size(kPercentiles); ++i)
    latency[kPercentileNames[i]] = latency_ms(tally, kPercentiles[i]);
  for (const auto& [status, count] : tally.other_statuses)
    json["failures"][std::to_string(status)] = count;
  return json;
}

std::size_t served_when_all_were_on(const client::FleetReport& report) {
  return report.tracking.served + report.searching.served;
}

double cpu_ms_per_batch(const client::FleetReport& report) {
  const std::size_t served = served_when_all_were_on(report);
  return served == 0 ? 0.0 : 1e3 * report.server_cpu_s / static_cast<double>(served);
}

void print_json(const LoadArguments& arguments, const client::FleetReport& report) {
  const nlohmann::ordered_json json = {{"robots", arguments.fleet.robots},
                                       {"batches_per_s", arguments.fleet.batches_per_s},
                                       {"scans_per_batch", arguments.fleet.batch},
                                       {"searching_share", arguments.fleet.searching},
                                       {"seconds", arguments.fleet.seconds},
                                       {"ramp", json_of(report.ramp)},
                                       {"tracking", json_of(report.tracking)},
                                       {"searching", json_of(report.searching)},
                                       {"server_cpu_ms_per_batch", cpu_ms_per_batch(report)}};
  std::printf("%s\n", json.dump(2).c_str());
}

std::string tenths(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

std::vector<std::string> row_of(const char* name, const client::BatchTally& tally) {
  std::vector<std::string> row = {name};
  for (const std::size_t count :
       {tally.offered, tally.served, tally.late, tally.shed, tally.failed, tally.localized})
    row.push_back(std::to_string(count));
  for (const double share : kPercentiles) row.push_back(tenths(latency_ms(tally, share)));
  return row;
}

void print_text(const client::FleetReport& report) {
  std::vector<std::vector<std::string>> rows = {{"robots", "offered", "served", "late", "shed",
                                                 "failed", "localized", "p50 ms", "p95 ms",
                                                 "p99 ms", "max ms"}};
  rows.push_back(row_of("coming", report.ramp));
  rows.push_back(row_of("tracking", report.tracking));
  if (report.searching.offered > 0) rows.push_back(row_of("searching", report.searching));
  print_table(rows);
  if (report.server_cpu_s > 0.0)
    std::printf("server: %.2f ms of processor time per batch\n", cpu_ms_per_batch(report));
}

int run_load(const LoadArguments& arguments) {
  const Result<evaluation::RecordedLog> log = read_whole_log(arguments.log, arguments.selection);
  if (!log) return fail(log.error());
  const Result<client::FleetReport> report = client::run_fleet(arguments.fleet, *log);
  if (!report) return fail(report.error());
  arguments.json ? print_json(arguments, *report) : print_text(*report);
  client::BatchTally all = report->tracking;
  all.add(report->searching);
  return all.served == all.offered && all.late == 0 ? kDone : kCouldNot;
}

void add_options(CLI::App& command, LoadArguments& arguments) {
  client::FleetOptions& fleet = arguments.fleet;
  add_log(command, arguments.log);
  add_selection(command, arguments.selection);
  command.add_option("--map", fleet.map, "Map to look in (default: all that the server has)")
      ->check(map_name());
  command.add_option("--robots", fleet.robots, "Robots")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  command.add_option("--rate", fleet.batches_per_s, "Batches per second and robot")
      ->check(above_zero())
      ->capture_default_str();
  command.add_option("--batch", fleet.batch, "Scans per batch")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      .add_option("--searching", fleet.searching,
                  "Share of robots that begin anew whenever they are localized")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--ramp", fleet.ramp_s, "Seconds until all robots are on")
      ->check(not_below_zero())
      ->capture_default_str();
  command.add_option("--seconds", fleet.seconds, "Seconds that all of them are on")
      ->check(above_zero())
      ->capture_default_str();
  command.add_flag("--json", arguments.json, "Print JSON");
}

}  // namespace

void add_load_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<LoadArguments>();
  CLI::App* command =
      app.add_subcommand("load", "Be a fleet: robots post a log's scans on a fixed schedule");
  command->footer(
      "Latency counts from when a batch was due. late: answered after the robot's next batch was\n"
      "due; shed: 429 or 503. Exit code 0 when all batches were served in time, else 1.");
  add_options(*command, *arguments);
  auto connection = std::make_shared<ConnectionOptions>();
  add_connection_options(*command, *connection);
  command->callback([arguments, connection, &exit_code] {
    arguments->fleet.server = connection->server;
    exit_code = run_load(*arguments);
  });
}

}  // namespace cornerfix::cli
