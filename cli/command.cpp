#include "cli/command.hpp"

#include <spdlog/fmt/chrono.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "api/requests.hpp"

namespace cornerfix::cli {

namespace {

/// The number that all of `text` is; NaN when it is none.
double number_in(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' ? number : std::nan("");
}

}  // namespace

std::string utc_now_text() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

int fail(const Error& error) {
  const std::string where = error.field.empty() ? "" : error.field + ": ";
  std::fprintf(stderr, "cornerfix: %s%s\n", where.c_str(), error.message.c_str());
  return kCouldNot;
}

void warn(const std::string& where, const std::string& what) {
  if (!what.empty()) std::fprintf(stderr, "cornerfix: %s: %s\n", where.c_str(), what.c_str());
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

void add_lidar_option(CLI::App& command, std::string& lidar) {
  command.add_option("--lidar", lidar,
                     "Topic of a bag, or message of a CARMEN log, with the scans to take (default: "
                     "that of the first scan)");
}

}  // namespace cornerfix::cli
