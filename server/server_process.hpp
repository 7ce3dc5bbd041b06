/// \file  The HTTP server as a process of its own: its signals, its log, its memory.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <cornerfix/result.hpp>

#include "server/server_config.hpp"

namespace cornerfix::server {

/// Where a configuration came from. SIGHUP reads its tokens again.
struct ConfigSource {
  std::optional<std::filesystem::path> file;
  std::vector<ConfigOverride> overrides;  ///< In the order in which they apply.
};

/// Serves until SIGTERM or SIGINT, then drains. Requests and jobs that are still in work when the
/// drain time and two more seconds are over are left, and the process ends with exit code 0. To be
/// called once, before the process has other threads: every thread made later leaves these signals
/// alone. \param on_listening  Called with the server's URL once it takes connections.
[[nodiscard]] Result<void> run_server_process(
    const ServerConfig& config, const ConfigSource& source,
    const std::function<void(const std::string& url)>& on_listening);

}  // namespace cornerfix::server
