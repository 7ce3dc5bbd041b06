#include "cli/command.hpp"

#include <spdlog/fmt/chrono.h>

#include <cstdio>
#include <ctime>

namespace cornerfix::cli {

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

void add_lidar_option(CLI::App& command, std::string& lidar) {
  command.add_option("--lidar", lidar,
                     "Topic of a bag, or message of a CARMEN log, with the scans to take (default: "
                     "that of the first scan)");
}

}  // namespace cornerfix::cli
