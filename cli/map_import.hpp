/// \file  `cornerfix map import`: a map from the files of ROS map_server.
#pragma once

#include <string>

#include "clients/cpp/server_connection.hpp"

namespace cornerfix::cli {

struct MapImportArguments {
  client::ConnectionOptions connection;
  std::string database;  ///< Where to write instead of asking a server; empty for the server.
  std::string name;
  std::string yaml;
};

/// Returns the exit code.
[[nodiscard]] int run_map_import(const MapImportArguments& arguments);

}  // namespace cornerfix::cli
