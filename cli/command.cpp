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

}  // namespace cornerfix::cli
