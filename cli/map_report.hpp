/// \file  `cornerfix map report`: how well robots will find themselves in a map.
#pragma once

#include <string>

#include "clients/cpp/server_connection.hpp"

namespace cornerfix::cli {

struct MapReportArguments {
  client::ConnectionOptions connection;
  std::string name;
  std::string picture;  ///< SVG to write; empty for none.
};

/// Returns the exit code.
int run_map_report(const MapReportArguments& arguments);

}  // namespace cornerfix::cli
