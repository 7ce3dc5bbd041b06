#include "cli/command.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "api/requests.hpp"
#include "cli/progress.hpp"

namespace cornerfix::cli {

namespace {

/// The number that all of `text` is; NaN when it is none.
double number_in(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' ? number : std::nan("");
}

}  // namespace

int fail(const Error& error) {
  const std::string where = error.field.empty() ? "" : error.field + ": ";
  std::fprintf(stderr, "cornerfix: %s%s\n", where.c_str(), error.message.c_str());
  return kCouldNot;
}

void warn(const std::string& where, const std::string& what) {
  if (!what.empty()) std::fprintf(stderr, "cornerfix: %s: %s\n", where.c_str(), what.c_str());
}

Result<evaluation::RecordedLog> read_whole_log(const std::string& path,
                                               const evaluation::LogSelection& selection,
                                               std::size_t stride) {
  Result<evaluation::LogReader> reader = evaluation::LogReader::open(path, selection);
  if (!reader) return reader.error();
  evaluation::RecordedLog log;
  {
    Progress progress("reading");
    log = evaluation::read_all(*reader, stride, [&](double share) { progress.update(share); });
  }
  if (auto error = reader->most_scans_lost()) return *error;
  warn(path, evaluation::remarks(*reader));
  return log;
}

Result<void> write_file(const std::string& path, const std::string& bytes) {
  const std::string partial = path + ".partial";
  std::ofstream file(partial, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(partial, path, error);
  if (file && !error) return {};
  std::filesystem::remove(partial, error);
  return Error{ErrorCode::kUnavailable, "cannot be written", path};
}

CLI::Validator above_zero() {
  return {[](std::string& text) {
            const double number = number_in(text);
            return number > 0.0 && std::isfinite(number) ? std::string()
                                                         : "expected a number above 0, not " + text;
          },
          "above 0"};
}

CLI::Validator not_below_zero() {
  return {[](std::string& text) {
            const double number = number_in(text);
            return number >= 0.0 && std::isfinite(number)
                       ? std::string()
                       : "expected a number from 0 on, not " + text;
          },
          "from 0 on"};
}

CLI::Validator map_name() {
  return {[](std::string& name) {
            return api::is_valid_name(name) ? std::string()
                                            : name +
                                                  " is no name for a map, which matches "
                                                  "[A-Za-z0-9][A-Za-z0-9._-]{0,127}";
          },
          ""};
}

void add_map_name(CLI::App& command, std::string& name) {
  command.add_option("NAME", name, "Name of the map")->required()->check(map_name());
}

CLI::Option* add_log(CLI::App& command, std::string& log) {
  return command
      .add_option("LOG", log,
                  "Recorded run: .jsonl, .log, .clf, .gfs, also .gz; .bag, .mcap, .db3, also "
                  ".zstd; or the directory of a bag")
      ->required()
      ->check(CLI::ExistingPath);
}

void add_selection(CLI::App& command, evaluation::LogSelection& selection) {
  command.add_option(
      "--lidar", selection.lidar,
      "Topic of a bag, message of a CARMEN log, or lidar of JSON lines, with the scans "
      "to take (default: the topic of the most beams, the lidar of the first scan)");
  command.add_option("--odom", selection.odometry,
                     "Topic of a bag with the odometry to take (default: tf, or else that of the "
                     "lidar's namespace)");
  command
      .add_option_function<std::pair<double, double>>(
          "--height",
          [&selection](const std::pair<double, double>& band) {
            if (!(band.first < band.second)) {
              throw CLI::ValidationError("--height", "expected the lower height first");
            }
            selection.height = {band.first, band.second};
          },
          "Heights above the sensor between which a point cloud becomes a scan [m] (default: "
          "-0.15 0.15)")
      ->type_name("MIN MAX");
  command
      .add_option("--scan-time", selection.scan_time,
                  "Seconds that the lidar takes for a scan, to straighten it by odometry (default: "
                  "the time_increment of the log)")
      ->check(above_zero());
}

}  // namespace cornerfix::cli
