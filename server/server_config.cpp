#include "server/server_config.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "server/settings.hpp"
#include "storage/database.hpp"

namespace cornerfix::server {
namespace {

using nlohmann::json;

std::string known_keys() {
  std::string keys;
  for (const Setting& setting : settings()) keys += (keys.empty() ? "" : ", ") + setting.key;
  return keys;
}

Result<std::string> read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return Error{ErrorCode::kNotFound, "cannot read the file of --config or CORNERFIX_CONFIG",
                 path.string()};
  return std::string(std::istreambuf_iterator<char>(file), {});
}

std::optional<Error> validate(const std::vector<Token>& tokens) {
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const std::string pointer = "/tokens/" + std::to_string(i);
    if (tokens[i].token.size() < 16) {
      return Error{ErrorCode::kInvalidArgument, "a token has at least 16 characters",
                   pointer + "/token"};
    }
    if (tokens[i].role == Role::kRobot && !api::is_valid_name(tokens[i].name)) {
      return Error{ErrorCode::kInvalidArgument, "a robot's token carries the robot's name",
                   pointer + "/name"};
    }
  }
  return std::nullopt;
}

Error in_file(const std::filesystem::path& file, Error error) {
  error.field = file.string() + (error.field.empty() ? "" : " at " + error.field);
  return error;
}

/// The pointer, with the variable or flag that gave its value in place of the key.
std::string source_of(const std::string& pointer, const std::vector<ConfigOverride>& overrides) {
  const std::size_t end = std::min(pointer.find('/', 1), pointer.size());
  const std::string_view key = std::string_view(pointer).substr(1, end - 1);
  const auto last = std::find_if(overrides.rbegin(), overrides.rend(),
                                 [&](const ConfigOverride& value) { return value.key == key; });
  return last == overrides.rend() ? pointer : last->source + pointer.substr(end);
}

/// An object. A key that is there twice is refused, since the reader would take the last one.
Result<json> parse_document(std::string_view text) {
  std::set<std::string> keys;
  std::string repeated;
  const auto look_at = [&](int depth, json::parse_event_t event, const json& value) {
    const bool is_key = event == json::parse_event_t::key && depth == 1;
    if (is_key && !keys.insert(value.get<std::string>()).second) repeated = value;
    return true;
  };
  json document;
  try {
    document = json::parse(text, look_at);
  } catch (const json::parse_error& error) {
    // "[json.exception.parse_error.101] parse error at line 3, column 1: ..."
    const std::string_view message = error.what();
    const std::size_t begin = std::min(message.find("parse error at"), message.size());
    return Error{ErrorCode::kMalformed,
                 "the configuration is not JSON: " + std::string(message.substr(begin)), ""};
  }
  if (!document.is_object()) {
    return Error{ErrorCode::kMalformed, "the configuration is not a JSON object", ""};
  }
  if (!repeated.empty())
    return Error{ErrorCode::kInvalidArgument, "is there twice, expected once", "/" + repeated};
  return document;
}

}  // namespace

std::optional<Role> role_from(std::string_view name) {
  if (name == "viewer") return Role::kViewer;
  if (name == "robot") return Role::kRobot;
  if (name == "mapper") return Role::kMapper;
  if (name == "admin") return Role::kAdmin;
  return std::nullopt;
}

Result<ServerConfig> merge_json(ServerConfig defaults, std::string_view text) {
  const Result<json> document = parse_document(text);
  if (!document) return document.error();
  for (const auto& [key, value] : document->items()) {
    const Setting* setting = find_setting(key);
    if (setting == nullptr) {
      return Error{ErrorCode::kInvalidArgument, "unknown key, expected one of " + known_keys(),
                   "/" + key};
    }
    if (const auto wrong = setting->set(defaults, value)) {
      return Error{ErrorCode::kInvalidArgument, *wrong, "/" + key};
    }
  }
  return defaults;
}

Result<ServerConfig> load_config(const std::optional<std::filesystem::path>& config_file,
                                 const std::vector<ConfigOverride>& overrides) {
  ServerConfig config;
  if (config_file) {
    const auto text = read_text(*config_file);
    if (!text) return text.error();
    auto merged = merge_json(std::move(config), *text);
    if (!merged) return in_file(*config_file, merged.error());
    config = std::move(*merged);
  }
  for (const ConfigOverride& value : overrides) {
    if (auto error = apply(config, value)) return *error;
  }
  if (auto error = validate(config)) {
    error->field = source_of(error->field, overrides);
    return *error;
  }
  return config;
}

bool is_open_to_others(const std::filesystem::path& file) {
  std::error_code error;
  const auto permissions = std::filesystem::status(file, error).permissions();
  using enum std::filesystem::perms;
  return !error && (permissions & (group_read | group_write | others_read | others_write)) != none;
}

std::optional<Error> validate(const ServerConfig& config) {
  if (config.database.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "no database is given (--db FILE or CORNERFIX_DATABASE)", "/database"};
  }
  if (config.port < 0 || config.port > 65535) {
    return Error{ErrorCode::kInvalidArgument, "a port is from 0 to 65535", "/port"};
  }
  if (auto error = validate(config.tokens)) return error;
  // A database that is there may hold tokens: that is looked up when it is opened.
  std::error_code error;
  const bool may_hold_tokens = storage::is_postgresql(config.database.native()) ||
                               std::filesystem::exists(config.database, error);
  if (may_hold_tokens) return std::nullopt;
  return check_listen(config, config.tokens.empty());
}

std::optional<Error> check_listen(const ServerConfig& config, bool is_open) {
  if (!is_open || config.allow_insecure_listen || is_loopback(config.listen)) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument,
               "without tokens anybody who reaches " + config.listen +
                   " could change every map; make some (cornerfix token create) or give "
                   "--allow-insecure-listen or CORNERFIX_ALLOW_INSECURE_LISTEN=true",
               "/listen"};
}

bool is_loopback(std::string_view address) {
  return address == "localhost" || address == "::1" || address.starts_with("127.");
}

}  // namespace cornerfix::server
