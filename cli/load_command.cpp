#include <cstdio>
#include <memory>
#include <string>

#include "cli/command.hpp"
#include "cli/server_options.hpp"
#include "cli/table.hpp"
#include "clients/cpp/fleet_report.hpp"

namespace cornerfix::cli {

namespace {

struct LoadArguments {
  client::FleetOptions fleet;
  std::string log;
  evaluation::LogSelection selection;
  bool json = false;
};

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
  for (const client::ReportedPercentile& percentile : client::kReportedPercentiles)
    row.push_back(tenths(client::latency_ms(tally, percentile.share)));
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
    std::printf("server: %.2f ms of processor time per batch\n", client::cpu_ms_per_batch(report));
}

int run_load(const LoadArguments& arguments) {
  const Result<evaluation::RecordedLog> log = read_whole_log(arguments.log, arguments.selection);
  if (!log) return fail(log.error());
  const Result<client::FleetReport> report = client::run_fleet(arguments.fleet, *log);
  if (!report) return fail(report.error());
  if (arguments.json) {
    std::printf("%s\n", client::fleet_report_json(arguments.fleet, *report).dump(2).c_str());
  } else {
    print_text(*report);
  }
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
  auto connection = std::make_shared<client::ConnectionOptions>();
  add_connection_options(*command, *connection);
  command->callback([arguments, connection, &exit_code] {
    arguments->fleet.server = connection->server;
    exit_code = run_load(*arguments);
  });
}

}  // namespace cornerfix::cli
