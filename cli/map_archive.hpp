/// \file  `cornerfix map export` and `restore`: a map as one file, out of a server and in.
#pragma once

#include <string>

#include "clients/cpp/server_connection.hpp"

namespace cornerfix::cli {

struct MapArchiveArguments {
  client::ConnectionOptions connection;
  std::string name;
  std::string file;
};

// Each returns the exit code.
[[nodiscard]] int run_map_export(const MapArchiveArguments& arguments);
[[nodiscard]] int run_map_restore(const MapArchiveArguments& arguments);

}  // namespace cornerfix::cli
