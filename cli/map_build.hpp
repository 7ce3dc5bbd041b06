/// \file  `cornerfix map build`: a map from the scans and poses of a recorded run.
#pragma once

#include <string>

#include "clients/cpp/server_connection.hpp"
#include "evaluation/datasets/mapping_scans.hpp"

namespace cornerfix::cli {

struct MapBuildArguments {
  client::ConnectionOptions connection;
  std::string database;  ///< Where to write instead of asking a server; empty for the server.
  std::string name;
  std::string log;
  evaluation::MappingScanOptions scans;
};

/// Returns the exit code.
[[nodiscard]] int run_map_build(const MapBuildArguments& arguments);

}  // namespace cornerfix::cli
