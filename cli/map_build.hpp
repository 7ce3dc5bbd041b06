/// \file  `cornerfix map build`: a map from the scans and poses of a recorded drive.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cli/log_reader.hpp"
#include "cli/server_connection.hpp"

namespace cornerfix::cli {

struct MapBuildArguments {
  ConnectionOptions connection;
  std::string database;  ///< Where to write instead of asking a server; empty for the server.
  std::string name;
  std::string log;
  double split = 1.0;
  std::size_t stride = 1;
  bool slam = false;  ///< Do without the log's poses: all scans, with odometry where it is there.
};

/// The scans of the first share of a log that can make a map: those with a pose, and in a log that
/// marks key scans those only, since the poses between them are interpolated.
[[nodiscard]] std::vector<LogScan> mapping_scans(RecordedLog log, double split);

/// Returns the exit code.
[[nodiscard]] int run_map_build(const MapBuildArguments& arguments);

}  // namespace cornerfix::cli
