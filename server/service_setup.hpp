/// \file  The services of a configuration, as a running server has them.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include <cornerfix/result.hpp>

#include "server/routes.hpp"
#include "server/server_config.hpp"

namespace cornerfix::server {

/// RFC 3339, UTC, to the second.
[[nodiscard]] std::string time_text(std::chrono::system_clock::time_point time);
/// The present time of the machine.
[[nodiscard]] std::string now_text();

/// Opens the database and makes the services. `load` is called for the metrics.
[[nodiscard]] Result<Services> open_services(const ServerConfig& config,
                                             std::function<ServerLoad()> load);

}  // namespace cornerfix::server
