#include "server/server_config.hpp"

#include <cstdint>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace cornerfix::server {
namespace {

using nlohmann::json;

/// Thrown inside this file only; ends in merge_json.
struct WrongValue : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string text_of(const json& value) {
  if (!value.is_string()) throw WrongValue("expected a string");
  return value.get<std::string>();
}

std::int64_t integer_of(const json& value, std::int64_t least, std::int64_t most) {
  const std::string expected =
      "expected an integer from " + std::to_string(least) + " to " + std::to_string(most);
  if (!value.is_number_integer()) throw WrongValue(expected);
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > static_cast<std::uint64_t>(most)) {
    throw WrongValue(expected);
  }
  const auto number = value.get<std::int64_t>();
  if (number < least || number > most) throw WrongValue(expected);
  return number;
}

std::size_t count_of(const json& value, std::int64_t most) {
  return static_cast<std::size_t>(integer_of(value, 1, most));
}

Role role_of(const json& value) {
  if (const auto role = role_from(text_of(value))) return *role;
  throw WrongValue(R"(expected "viewer", "robot", "mapper" or "admin")");
}

LogFormat log_format_of(const json& value) {
  const std::string name = text_of(value);
  if (name == "text") return LogFormat::kText;
  if (name == "json") return LogFormat::kJson;
  throw WrongValue(R"(expected "text" or "json")");
}

Token token_of(const json& value) {
  if (!value.is_object()) throw WrongValue("expected an object");
  Token token;
  for (const auto& [key, member] : value.items()) {
    if (key == "token") {
      token.token = text_of(member);
    } else if (key == "role") {
      token.role = role_of(member);
    } else if (key == "name") {
      token.name = text_of(member);
    } else {
      throw WrongValue("unknown key \"" + key + "\", expected token, role and name");
    }
  }
  if (!value.contains("role")) throw WrongValue("role is missing");
  return token;
}

using Setter = std::function<void(ServerConfig&, const json&)>;

constexpr std::int64_t kMaxBytes = std::int64_t{1} << 40;

const std::map<std::string, Setter, std::less<>>& setters() {
  static const std::map<std::string, Setter, std::less<>> table = {
      {"database", [](auto& c, const json& v) { c.database = text_of(v); }},
      {"listen", [](auto& c, const json& v) { c.listen = text_of(v); }},
      {"port", [](auto& c, const json& v) { c.port = static_cast<int>(integer_of(v, 0, 65535)); }},
      {"allow_insecure_listen",
       [](auto& c, const json& v) {
         if (!v.is_boolean()) throw WrongValue("expected true or false");
         c.allow_insecure_listen = v.get<bool>();
       }},
      {"tokens",
       [](auto& c, const json& v) {
         if (!v.is_array()) throw WrongValue("expected an array");
         c.tokens.clear();
         for (const json& token : v) c.tokens.push_back(token_of(token));
       }},
      {"allowed_hosts",
       [](auto& c, const json& v) {
         if (!v.is_array()) throw WrongValue("expected an array of names");
         c.allowed_hosts.clear();
         for (const json& host : v) c.allowed_hosts.push_back(text_of(host));
       }},
      {"log_format", [](auto& c, const json& v) { c.log_format = log_format_of(v); }},
      {"web_root", [](auto& c, const json& v) { c.web_root = text_of(v); }},
      {"leaflet_root", [](auto& c, const json& v) { c.leaflet_root = text_of(v); }},
      {"chart_root", [](auto& c, const json& v) { c.chart_root = text_of(v); }},
      {"max_body_bytes",
       [](auto& c, const json& v) { c.max_body_bytes = count_of(v, std::int64_t{1} << 31); }},
      {"max_scans",
       [](auto& c, const json& v) { c.request_limits.max_scans = count_of(v, 1'000'000); }},
      {"max_beams",
       [](auto& c, const json& v) { c.request_limits.max_beams = count_of(v, 10'000'000); }},
      {"max_connections",
       [](auto& c, const json& v) { c.max_connections = count_of(v, 1'000'000); }},
      {"max_connections_per_address",
       [](auto& c, const json& v) { c.max_connections_per_address = count_of(v, 1'000'000); }},
      {"worker_threads", [](auto& c, const json& v) { c.worker_threads = count_of(v, 10'000); }},
      {"max_requests_in_work",
       [](auto& c, const json& v) { c.max_requests_in_work = count_of(v, 10'000); }},
      {"max_event_clients",
       [](auto& c, const json& v) { c.max_event_clients = count_of(v, 10'000); }},
      {"keep_alive_timeout_s",
       [](auto& c, const json& v) {
         c.keep_alive_timeout_s = static_cast<int>(integer_of(v, 1, 3600));
       }},
      {"queue_timeout_ms",
       [](auto& c, const json& v) {
         c.queue_timeout_ms = static_cast<int>(integer_of(v, 1, 60'000));
       }},
      {"drain_timeout_s",
       [](auto& c, const json& v) {
         c.drain_timeout_s = static_cast<int>(integer_of(v, 0, 3600));
       }},
      {"min_free_bytes", [](auto& c, const json& v) { c.min_free_bytes = count_of(v, kMaxBytes); }},
      {"max_map_bytes", [](auto& c, const json& v) { c.max_map_bytes = count_of(v, kMaxBytes); }},
      {"max_searched_map_bytes",
       [](auto& c, const json& v) { c.max_searched_map_bytes = count_of(v, kMaxBytes); }},
      {"max_mappers", [](auto& c, const json& v) { c.max_mappers = count_of(v, 10'000); }},
      {"max_session_bytes",
       [](auto& c, const json& v) { c.max_session_bytes = count_of(v, kMaxBytes); }},
      {"max_sessions_per_robot",
       [](auto& c, const json& v) { c.max_sessions_per_robot = count_of(v, 1'000'000); }},
      {"session_expiry_days",
       [](auto& c, const json& v) {
         c.session_expiry_days = static_cast<int>(integer_of(v, 1, 36'500));
       }},
      {"session_stale_s",
       [](auto& c, const json& v) {
         c.session_stale_s = static_cast<int>(integer_of(v, 1, 31'536'000));
       }},
      {"session_idle_minutes",
       [](auto& c, const json& v) {
         c.session_idle_minutes = static_cast<int>(integer_of(v, 1, 1'000'000));
       }},
  };
  return table;
}

std::string known_keys() {
  std::string keys;
  for (const auto& [key, setter] : setters()) keys += (keys.empty() ? "" : ", ") + key;
  return keys;
}

Result<std::string> read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, "cannot read the file", path.string()};
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

}  // namespace

std::optional<Role> role_from(std::string_view name) {
  if (name == "viewer") return Role::kViewer;
  if (name == "robot") return Role::kRobot;
  if (name == "mapper") return Role::kMapper;
  if (name == "admin") return Role::kAdmin;
  return std::nullopt;
}

Result<ServerConfig> merge_json(ServerConfig defaults, std::string_view text) {
  const json document = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!document.is_object()) {
    return Error{ErrorCode::kMalformed, "the configuration is not a JSON object", ""};
  }
  for (const auto& [key, value] : document.items()) {
    const auto setter = setters().find(key);
    if (setter == setters().end()) {
      return Error{ErrorCode::kInvalidArgument, "unknown key, expected one of " + known_keys(),
                   "/" + key};
    }
    try {
      setter->second(defaults, value);
    } catch (const WrongValue& wrong) {
      return Error{ErrorCode::kInvalidArgument, wrong.what(), "/" + key};
    }
  }
  return defaults;
}

Result<ServerConfig> load_config(const std::optional<std::filesystem::path>& config_file,
                                 const ServerFlags& flags) {
  ServerConfig config;
  if (config_file) {
    const auto text = read_text(*config_file);
    if (!text) return text.error();
    auto merged = merge_json(std::move(config), *text);
    if (!merged) return merged.error();
    config = std::move(*merged);
  }
  if (flags.database) config.database = *flags.database;
  if (flags.listen) config.listen = *flags.listen;
  if (flags.port) config.port = *flags.port;
  config.allow_insecure_listen |= flags.allow_insecure_listen;
  if (auto error = validate(config)) return *error;
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
    return Error{ErrorCode::kInvalidArgument, "no database is given (--db FILE)", "/database"};
  }
  if (config.port < 0 || config.port > 65535) {
    return Error{ErrorCode::kInvalidArgument, "a port is from 0 to 65535", "/port"};
  }
  if (auto error = validate(config.tokens)) return error;
  // A database that is there may hold tokens: that is looked up when it is opened.
  std::error_code error;
  if (std::filesystem::exists(config.database, error)) return std::nullopt;
  return check_listen(config, config.tokens.empty());
}

std::optional<Error> check_listen(const ServerConfig& config, bool is_open) {
  if (!is_open || config.allow_insecure_listen || is_loopback(config.listen)) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument,
               "without tokens anybody who reaches " + config.listen +
                   " could change every map; make some (cornerfix token create) or say "
                   "--allow-insecure-listen",
               "/listen"};
}

bool is_loopback(std::string_view address) {
  return address == "localhost" || address == "::1" || address.starts_with("127.");
}

}  // namespace cornerfix::server
