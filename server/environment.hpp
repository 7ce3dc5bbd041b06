/// \file  The variables CORNERFIX_… of the environment, which override the configuration file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "server/server_config.hpp"

namespace cornerfix::server {

struct Environment {
  std::optional<std::filesystem::path> config_file;  ///< CORNERFIX_CONFIG.
  std::vector<ConfigOverride> overrides;
  std::vector<std::string> unknown;  ///< Variables CORNERFIX_… that are no settings.
};

/// Of `variables`, an array of "NAME=value" that ends with null, such as environ(7). A variable
/// with an empty value is not set.
[[nodiscard]] Environment read_environment(const char* const* variables);

}  // namespace cornerfix::server
