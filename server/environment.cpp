#include "server/environment.hpp"

#include <algorithm>
#include <string_view>

#include "server/settings.hpp"

namespace cornerfix::server {

Environment read_environment(const char* const* variables) {
  Environment environment;
  for (; *variables != nullptr; ++variables) {
    const std::string_view variable = *variables;
    const std::string name(variable.substr(0, variable.find('=')));
    if (!name.starts_with("CORNERFIX_") || name.size() + 1 >= variable.size()) continue;
    std::string value(variable.substr(name.size() + 1));
    if (name == "CORNERFIX_CONFIG") {
      environment.config_file = value;
      continue;
    }
    if (name == "CORNERFIX_TOKEN") continue;  // Of the commands that call a server.
    const auto setting = std::ranges::find(settings(), name, &Setting::variable);
    if (setting == settings().end()) {
      environment.unknown.push_back(name);
    } else {
      environment.overrides.push_back({setting->key, std::move(value), name});
    }
  }
  return environment;
}

}  // namespace cornerfix::server
