#include "server/settings.hpp"

#include <algorithm>
#include <cassert>
#include <cctype>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "api/answer_history.hpp"

namespace cornerfix::server {
namespace {

using nlohmann::json;
using Kind = Setting::Kind;

/// Thrown inside this file only; ends in made().
struct WrongValue : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string text_of(const json& value) {
  if (!value.is_string()) throw WrongValue("expected a string");
  return value.get<std::string>();
}

bool switch_of(const json& value) {
  if (!value.is_boolean()) throw WrongValue("expected true or false");
  return value.get<bool>();
}

struct Limits {
  std::int64_t least;
  std::int64_t most;
};

std::int64_t integer_of(const json& value, Limits limits) {
  const std::string expected = "expected an integer from " + std::to_string(limits.least) + " to " +
                               std::to_string(limits.most);
  if (!value.is_number_integer()) throw WrongValue(expected);
  if (value.is_number_unsigned() &&
      value.get<std::uint64_t>() > static_cast<std::uint64_t>(limits.most)) {
    throw WrongValue(expected);
  }
  const auto number = value.get<std::int64_t>();
  if (number < limits.least || number > limits.most) throw WrongValue(expected);
  return number;
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

std::vector<Token> tokens_of(const json& value) {
  if (!value.is_array()) throw WrongValue("expected an array of tokens");
  std::vector<Token> tokens;
  for (const json& token : value) tokens.push_back(token_of(token));
  return tokens;
}

std::vector<std::string> names_of(const json& value) {
  if (!value.is_array()) throw WrongValue("expected an array of names");
  std::vector<std::string> names;
  for (const json& name : value) names.push_back(text_of(name));
  return names;
}

/// `assign` is called with a configuration and a value, and throws WrongValue.
template <typename Assign>
Setting made(std::string key, Kind kind, std::string default_value, std::string meaning,
             Assign assign) {
  return {std::move(key), std::move(meaning), std::move(default_value), kind,
          [assign](ServerConfig& config, const json& value) -> std::optional<std::string> {
            try {
              assign(config, value);
            } catch (const WrongValue& wrong) {
              return wrong.what();
            }
            return std::nullopt;
          }};
}

/// `member` gives the integer of a configuration: a pointer to a member, or a function.
template <typename Member>
Setting integer(std::string key, Member member, Limits limits, std::string meaning) {
  ServerConfig defaults;
  auto& number = std::invoke(member, defaults);
  return made(std::move(key), Kind::kInteger, std::to_string(number), std::move(meaning),
              [member, limits](ServerConfig& config, const json& value) {
                auto& to = std::invoke(member, config);
                to = static_cast<std::remove_reference_t<decltype(to)>>(integer_of(value, limits));
              });
}

template <typename Text>
Setting text(std::string key, Text ServerConfig::*member, std::string meaning) {
  const ServerConfig defaults;
  return made(
      std::move(key), Kind::kText, std::string(defaults.*member), std::move(meaning),
      [member](ServerConfig& config, const json& value) { config.*member = text_of(value); });
}

constexpr Limits kBytes{1, std::int64_t{1} << 40};

std::vector<Setting> access_settings() {
  return {
      text("database", &ServerConfig::database,
           "SQLite file, made when it does not exist, or postgresql://user@host/name"),
      text("listen", &ServerConfig::listen, "Address to bind"),
      integer("port", &ServerConfig::port, {0, 65535}, "Port; 0 takes a free one"),
      made(
          "allow_insecure_listen", Kind::kSwitch, "false",
          "Bind to more than loopback without any tokens",
          [](auto& config, const json& value) { config.allow_insecure_listen = switch_of(value); }),
      made("allowed_hosts", Kind::kNames, "",
           "Names of the server in Host headers, when there are no tokens",
           [](auto& config, const json& value) { config.allowed_hosts = names_of(value); }),
      made("tokens", Kind::kTokens, "", "Tokens beside those of `cornerfix token create`",
           [](auto& config, const json& value) { config.tokens = tokens_of(value); }),
      made("log_format", Kind::kText, "",
           "`text` or `json`, on stderr; text on a terminal and JSON elsewhere if not set",
           [](auto& config, const json& value) { config.log_format = log_format_of(value); }),
      text("web_root", &ServerConfig::web_root, "The inspector's files, where they were moved"),
      text("leaflet_root", &ServerConfig::leaflet_root, "Files of Leaflet"),
      text("chart_root", &ServerConfig::chart_root, "Files of Chart.js"),
  };
}

std::vector<Setting> request_settings() {
  return {
      integer("max_body_bytes", &ServerConfig::max_body_bytes, {1, std::int64_t{1} << 31},
              "Of a request, after decompression"),
      integer(
          "max_scans", [](auto& config) -> auto& { return config.request_limits.max_scans; },
          {1, 1'000'000}, "Scans of a request"),
      integer(
          "max_beams", [](auto& config) -> auto& { return config.request_limits.max_beams; },
          {1, 10'000'000}, "Beams of a scan"),
      integer("max_connections", &ServerConfig::max_connections, {1, 1'000'000},
              "Open connections; more are answered 503"),
      integer("max_connections_per_address", &ServerConfig::max_connections_per_address,
              {1, 1'000'000}, "Open connections of one address; more are answered 503"),
      integer("worker_threads", &ServerConfig::worker_threads, {1, 10'000},
              "Requests answered at the same time"),
      integer("max_requests_in_work", &ServerConfig::max_requests_in_work, {1, 10'000},
              "Requests answered or waiting for a thread; more are answered 503"),
      integer("queue_timeout_ms", &ServerConfig::queue_timeout_ms, {1, 60'000},
              "A request that waits longer for a thread is answered 503"),
      integer("max_event_clients", &ServerConfig::max_event_clients, {1, 10'000},
              "Clients of Server-Sent Events; each holds a thread"),
      integer("keep_alive_timeout_s", &ServerConfig::keep_alive_timeout_s, {1, 3600},
              "An idle connection is closed after this time"),
      integer("drain_timeout_s", &ServerConfig::drain_timeout_s, {0, 3600},
              "Time for open requests after SIGTERM"),
      integer("max_requests_per_second", &ServerConfig::max_requests_per_second, {1, 1'000'000},
              "Of a token's holder, or of an address without tokens; more are answered 429"),
      integer("max_wrong_tokens", &ServerConfig::max_wrong_tokens, {1, 1'000'000},
              "Different wrong tokens of an address within a minute; then it is locked out"),
      integer("lockout_s", &ServerConfig::lockout_s, {1, 86'400},
              "How long an address is locked out after wrong tokens: answered 429"),
  };
}

std::vector<Setting> storage_settings() {
  return {
      integer("min_free_bytes", &ServerConfig::min_free_bytes, kBytes,
              "Free on the database's disk; below, /readyz is 503"),
      integer(
          "max_map_bytes", &ServerConfig::max_map_bytes, kBytes,
          "Of loaded maps, those that robots hold included; the least recently used are released"),
      integer("max_searched_map_bytes", &ServerConfig::max_searched_map_bytes, kBytes,
              "Of maps that one session searches; with more, its batches are answered 409"),
      integer("max_mappers", &ServerConfig::max_mappers, {1, 10'000},
              "Maps in memory to which scans are being added"),
      integer("max_maps", &ServerConfig::max_maps, {1, 10'000'000},
              "Maps in the database; more are answered 429"),
      integer("max_database_bytes", &ServerConfig::max_database_bytes, kBytes,
              "Of the database; above it growing maps and new sessions are answered 429"),
      integer("kept_revisions", &ServerConfig::kept_revisions, {0, 1000},
              "Former revisions of each map that stay in the database, for a roll-back"),
      integer("max_sessions", &ServerConfig::max_sessions, {1, 100'000'000},
              "Sessions in the database; more are answered 429"),
      integer("max_session_bytes", &ServerConfig::max_session_bytes, kBytes,
              "Of sessions in memory; the least used ones wait in the database"),
      integer("max_sessions_per_robot", &ServerConfig::max_sessions_per_robot, {1, 1'000'000},
              "Sessions of a robot; more are answered 429"),
      integer("session_idle_minutes", &ServerConfig::session_idle_minutes, {1, 1'000'000},
              "A session leaves memory after this time without a batch"),
      integer("checkpoint_interval_s", &ServerConfig::checkpoint_interval_s, {0, 3600},
              "Sessions are stored so often; 0: each batch before its answer"),
      integer("session_stale_s", &ServerConfig::session_stale_s, {1, 31'536'000},
              "A session without a batch for longer is stale"),
      integer("recorded_answers", &ServerConfig::recorded_answers,
              {0, api::AnswerHistory::kMaxAnswers},
              "Newest answers of a session that stay in memory with their scans"),
      integer("session_expiry_days", &ServerConfig::session_expiry_days, {1, 36'500},
              "A session is removed after this time without a batch"),
      integer("max_jobs", &ServerConfig::max_jobs, {1, 100'000},
              "Jobs in the database that are not finished; more are answered 429"),
      integer("max_job_bytes", &ServerConfig::max_job_bytes, kBytes,
              "Of the input of these jobs; more is answered 429"),
      integer("job_expiry_hours", &ServerConfig::job_expiry_hours, {1, 876'000},
              "A finished job is removed after this time"),
  };
}

json split_names(std::string_view text) {
  json names = json::array();
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    names.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return names;
}

/// A text that is no JSON stays a text, which is a wrong value for the kinds that want JSON.
json value_of(Kind kind, const std::string& text) {
  if (kind == Kind::kText) return text;
  if (kind == Kind::kNames) return split_names(text);
  json value = json::parse(text, nullptr, /*allow_exceptions=*/false);
  return value.is_discarded() ? json(text) : value;
}

}  // namespace

std::string Setting::variable() const {
  std::string name = "CORNERFIX_" + key;
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::toupper(c); });
  return name;
}

std::string Setting::flag() const {
  if (kind == Kind::kTokens) return {};
  std::string name = "--" + key;
  std::ranges::replace(name, '_', '-');
  return name;
}

const std::vector<Setting>& settings() {
  static const std::vector<Setting> all = [] {
    std::vector<Setting> joined = access_settings();
    for (auto more : {request_settings(), storage_settings()}) {
      std::ranges::move(more, std::back_inserter(joined));
    }
    return joined;
  }();
  return all;
}

const Setting* find_setting(std::string_view key) {
  const auto setting = std::ranges::find(settings(), key, &Setting::key);
  return setting == settings().end() ? nullptr : &*setting;
}

std::optional<Error> apply(ServerConfig& config, const ConfigOverride& value) {
  const Setting* setting = find_setting(value.key);
  assert(setting != nullptr);
  const auto expected = setting->set(config, value_of(setting->kind, value.text));
  if (!expected) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument, *expected, value.source};
}

}  // namespace cornerfix::server
