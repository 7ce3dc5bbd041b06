/// \file  Settings of the service: defaults, overridden by a JSON file, by variables of the
/// environment and by flags, in this order.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/result.hpp>

#include "api/requests.hpp"
#include "server/event_log.hpp"
#include "storage/map_revisions.hpp"

namespace cornerfix::server {

/// What a token may do: kViewer reads, kRobot runs its own robot's sessions, kMapper changes maps,
/// kAdmin does all.
enum class Role { kViewer, kRobot, kMapper, kAdmin };

/// Of "viewer", "robot", "mapper" and "admin".
[[nodiscard]] std::optional<Role> role_from(std::string_view name);

struct Token {
  std::string token;
  Role role = Role::kViewer;
  std::string name;  ///< Of the holder; for kRobot the only robot whose sessions it opens.
};

struct ServerConfig {
  std::filesystem::path database;                       ///< Or a URL, as Database::open().
  std::size_t min_free_bytes = std::size_t{16} << 20U;  ///< On its disk; below, /readyz is 503.
  std::string listen = "127.0.0.1";                     ///< Address to bind.
  int port = 8080;                                      ///< 0 takes a free one.
  bool allow_insecure_listen = false;  ///< Bind to more than loopback in spite of having no tokens.
  std::vector<Token> tokens;           ///< Empty: everybody may do everything.
  /// Names of the server in Host headers, beside those that HostCheck knows. Used without tokens.
  std::vector<std::string> allowed_hosts;

  /// Nothing: text on a terminal, JSON elsewhere.
  std::optional<LogFormat> log_format;

  std::filesystem::path web_root;  ///< The inspector's files; empty: where they were installed.
  std::filesystem::path leaflet_root = "/usr/share/javascript/leaflet";
  std::filesystem::path chart_root = "/usr/share/javascript/chart.js";

  std::size_t max_body_bytes = std::size_t{16} << 20U;  ///< After decompression.
  api::RequestLimits request_limits;

  std::size_t max_connections = 16'000;              ///< They hold no threads.
  std::size_t max_connections_per_address = 12'000;  ///< A proxy's robots all have its address.
  std::size_t worker_threads = 32;                   ///< Requests answered at the same time.
  std::size_t max_requests_in_work = 256;            ///< More are answered 503.
  std::size_t max_event_clients = 16;  ///< Each holds a thread for as long as it listens.
  int keep_alive_timeout_s = 60;       ///< Then an idle connection is closed.
  int queue_timeout_ms = 10'000;       ///< A request waiting longer for a thread gets 503.
  int drain_timeout_s = 5;             ///< After SIGTERM; then connections are closed.

  /// Of a token's holder, or of an address where there are no tokens; more are answered 429.
  std::size_t max_requests_per_second = 2000;
  std::size_t max_wrong_tokens = 20;  ///< Different ones of an address within a minute; then
  int lockout_s = 60;                 ///< it is locked out for so long.

  std::size_t max_map_bytes = std::size_t{1} << 30U;  ///< Of loaded maps, those in use too.
  /// Of the maps that one session searches together; with more, its batches are answered 409.
  std::size_t max_searched_map_bytes = std::size_t{4} << 30U;
  std::size_t max_mappers = 4;    ///< Growing maps kept in memory.
  std::size_t max_maps = 20'000;  ///< In the database; more are answered 429.
  /// Of the database; above it no map grows and no session begins.
  std::size_t max_database_bytes = std::size_t{64} << 30U;
  std::size_t kept_revisions = storage::kDefaultKeptRevisions;  ///< Former ones of each map.
  int session_idle_minutes = 30;  ///< Then a session is kept in the database only.
  std::size_t max_session_bytes = std::size_t{2} << 30U;  ///< Of sessions kept in memory.
  std::size_t max_sessions = 100'000;        ///< In the database; more are answered 429.
  std::size_t max_sessions_per_robot = 100;  ///< More are answered 429.
  int session_expiry_days = 30;              ///< Then an unused session is removed.
  std::size_t recorded_answers = 0;          ///< Of a session, kept in memory with their scans.
  std::size_t max_jobs = 64;  ///< Unfinished, in the database; more are answered 429.
  std::size_t max_job_bytes = std::size_t{1} << 30U;  ///< Of their input; more is answered 429.
  int job_expiry_hours = 24;                          ///< Then a finished job is removed.
  int checkpoint_interval_s = 0;                      ///< 0: a batch is stored before its answer.
  int session_stale_s = 60;  ///< Without a batch for longer, a session is `stale`.
};

/// A value that comes from outside the configuration file.
struct ConfigOverride {
  std::string key;     ///< In the file.
  std::string text;    ///< As a person wrote it.
  std::string source;  ///< "--port" or "CORNERFIX_PORT", for errors.
};

/// `defaults` with the members of a JSON object put over them. An unknown key, a wrong type or a
/// value outside its limits is an error whose `field` is the JSON pointer.
[[nodiscard]] Result<ServerConfig> merge_json(ServerConfig defaults, std::string_view json);

/// The settings to run with: defaults, the file (when given), then `overrides` in their order.
/// Checked as a whole. The `field` of an error names the pointer, variable or flag.
[[nodiscard]] Result<ServerConfig> load_config(
    const std::optional<std::filesystem::path>& config_file,
    const std::vector<ConfigOverride>& overrides);

/// Whether others than the owner can read or change the file, which is not for one with tokens.
[[nodiscard]] bool is_open_to_others(const std::filesystem::path& file);

/// The first broken limit, or nothing; check_listen() as far as that is known without the database.
[[nodiscard]] std::optional<Error> validate(const ServerConfig& config);

/// Without tokens (`is_open`) only loopback may be bound, unless `allow_insecure_listen` says so.
[[nodiscard]] std::optional<Error> check_listen(const ServerConfig& config, bool is_open);

[[nodiscard]] bool is_loopback(std::string_view address);

}  // namespace cornerfix::server
