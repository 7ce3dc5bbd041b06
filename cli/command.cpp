#include "cli/command.hpp"

#include <cstdio>

namespace cornerfix::cli {

int fail(const Error& error) {
  const std::string where = error.field.empty() ? "" : error.field + ": ";
  std::fprintf(stderr, "cornerfix: %s%s\n", where.c_str(), error.message.c_str());
  return kCouldNot;
}

}  // namespace cornerfix::cli
