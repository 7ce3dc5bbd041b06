#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "cli/command.hpp"
#include "cli/map_commands.hpp"
#include "cli/progress.hpp"
#include "cli/server_options.hpp"
#include "cli/table.hpp"

namespace cornerfix::cli {

namespace {

struct MapReportArguments {
  client::ConnectionOptions connection;
  std::string name;
  std::string picture;  ///< SVG to write; empty for none.
};

constexpr std::size_t kMaxRows = 10;
constexpr std::chrono::milliseconds kPause{300};

template <typename... Values>
std::string text(const char* pattern, Values... values) {
  char out[96];
  std::snprintf(out, sizeof out, pattern, values...);
  return out;
}

std::string place_text(const nlohmann::json& place) {
  if (!place.is_object()) return "-";
  return text("%.1f, %.1f", place.value("x", 0.0), place.value("y", 0.0));
}

/// Asks until the report is made. A server that lets enough callers wait answers at once, hence the
/// pause.
Result<nlohmann::json> wait_for_report(client::ServerConnection& server, const std::string& path) {
  Progress progress("simulating");
  for (;;) {
    Result<nlohmann::json> report = server.call({"GET", path + "?wait=2"});
    if (!report || report->value("state", "done") == "done") return report;
    progress.update(report->value("progress", 0.0));
    std::this_thread::sleep_for(kPause);
  }
}

void print_areas(const nlohmann::json& areas) {
  std::vector<std::vector<std::string>> rows = {
      {"REGION", "RADIUS", "DISTANCE", "LOCALIZED", "ALIASED WITH", "BETTER START"}};
  for (const auto& area : areas) {
    if (rows.size() > kMaxRows) break;
    rows.push_back({place_text(area), text("%.1f m", area.value("radius_m", 0.0)),
                    text("%.1f m", area.value("way_m", 0.0)),
                    text("%.0f %%", 100.0 * area.value("found", 0.0)),
                    place_text(area.value("looks_like", nlohmann::json())),
                    place_text(area.value("better_start", nlohmann::json()))});
  }
  if (rows.size() > 1) print_table(rows);
}

void print_report(const nlohmann::json& report) {
  std::printf("%s\n", report.value("summary", "").c_str());
  std::printf("%.0f m2 free, %.1f features in 100 m2\n\n", report.value("free_area_m2", 0.0),
              report.value("features_per_100_m2", 0.0));
  print_areas(report.value("areas", nlohmann::json::array()));
  for (const auto& sentence : report.value("advice", std::vector<std::string>{}))
    std::printf("- %s\n", sentence.c_str());
}

Result<void> write_picture(client::ServerConnection& server, const std::string& path,
                           const std::string& file_path) {
  client::HttpRequest request{"GET", path + ".svg"};
  request.answer_path = file_path;
  const Result<std::string> svg = server.fetch(request);
  if (!svg) return svg.error();
  if (server.is_printing()) return {};
  return write_file(file_path, *svg);
}

int run_map_report(const MapReportArguments& arguments) {
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  const std::string path = "/v1/maps/" + client::percent_encode(arguments.name) + "/report";
  const Result<nlohmann::json> report =
      server->is_printing() ? server->call({"GET", path}) : wait_for_report(*server, path);
  if (!report) return fail(report.error());
  if (!server->is_printing()) print_report(*report);
  if (arguments.picture.empty()) return kDone;
  const Result<void> written = write_picture(*server, path, arguments.picture);
  return written ? kDone : fail(written.error());
}

}  // namespace

void add_map_report_command(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<MapReportArguments>();
  CLI::App* command =
      map.add_subcommand("report", "Show where robots are localized in a map, and where not");
  command->footer(
      "Simulated robots are switched on all over the map's free space and drive until they are\n"
      "localized. They have the map's lidar, or one of 180 deg with a range of 30 m.");
  add_map_name(*command, arguments->name);
  command->add_option("--picture", arguments->picture, "Draw it into this file (SVG)");
  add_connection_options(*command, arguments->connection);
  command->callback([arguments, &exit_code] { exit_code = run_map_report(*arguments); });
}

}  // namespace cornerfix::cli
