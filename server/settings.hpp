/// \file  The settings of the service by name: keys of the configuration file, variables of the
/// environment and flags of the command line.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/result.hpp>

#include "server/server_config.hpp"

namespace cornerfix::server {

struct Setting {
  /// kNames: in texts, separated by commas. kTokens: in texts, JSON as in the file.
  enum class Kind { kText, kInteger, kSwitch, kNames, kTokens };

  std::string key;      ///< In the file: "worker_threads".
  std::string meaning;  ///< For `cornerfix serve --help`.
  std::string default_value;
  Kind kind = Kind::kText;
  /// Puts a value of the file into the configuration. Returns what was expected if it is wrong.
  std::function<std::optional<std::string>(ServerConfig&, const nlohmann::json&)> set;

  [[nodiscard]] std::string variable() const;  ///< "CORNERFIX_WORKER_THREADS".
  /// "--worker-threads". Empty for tokens: every user of a machine sees the arguments of programs.
  [[nodiscard]] std::string flag() const;
};

/// All of them, in the order of `cornerfix serve --help`.
[[nodiscard]] const std::vector<Setting>& settings();

/// Null when there is none with this key.
[[nodiscard]] const Setting* find_setting(std::string_view key);

/// Puts the text of a variable or flag into the configuration; its key is that of a setting. The
/// `field` of an error is the source of the text.
[[nodiscard]] std::optional<Error> apply(ServerConfig& config, const ConfigOverride& value);

}  // namespace cornerfix::server
