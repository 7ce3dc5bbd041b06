#include "server/server_process.hpp"

#include <malloc.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <utility>

#include "server/event_log.hpp"
#include "server/http_server.hpp"
#include "server/stop_signals.hpp"

namespace cornerfix::server {
namespace {

/// Robots of a whole fleet run on many threads; more heaps than this only cost memory.
constexpr int kMaxHeaps = 4;
/// Buffers from this size on go back to the system as soon as they are let go. By default the C
/// library keeps ever larger ones, and what a large map needed while it was loaded would stay.
constexpr int kMappedBufferBytes = 1 << 20;
/// On top of the drain time, for batches and the job that are being worked on: then the process
/// ends anyway. What was acknowledged is then in the database, and the job is in the queue.
constexpr std::chrono::seconds kLastWorkTime{2};

/// Takes over the tokens of the configuration file. When it cannot be used, the old ones stay.
void reload_tokens(HttpServer& server, const ConfigSource& source) {
  if (!source.file) {
    spdlog::warn("SIGHUP reloads the tokens of the configuration file, but there is none: ignored");
    return;
  }
  auto config = load_config(source.file, source.overrides);
  if (!config) {
    spdlog::error("the tokens stay as they were: {}{}{}", config.error().message,
                  config.error().field.empty() ? "" : " at ", config.error().field);
    return;
  }
  spdlog::info("reloaded {} tokens", config->tokens.size());
  server.set_tokens(std::move(config->tokens));
}

/// With a checkpoint interval, the last batches are in memory only.
void store_sessions(HttpServer& server) {
  const std::size_t failed = server.store_sessions();
  if (failed > 0) spdlog::error("{} sessions are not stored: they lose their last batches", failed);
}

/// Connections need descriptors, and the usual limit of 1,024 is far below what the loop can hold.
void raise_descriptor_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

/// What the system gives a process by default is for smaller ones.
void claim_resources() {
  mallopt(M_ARENA_MAX, kMaxHeaps);
  mallopt(M_MMAP_THRESHOLD, kMappedBufferBytes);
  raise_descriptor_limit();
}

void begin_process_log(const ServerConfig& config, const ConfigSource& source) {
  const bool is_terminal = ::isatty(STDERR_FILENO) == 1;
  begin_log(config.log_format.value_or(is_terminal ? LogFormat::kText : LogFormat::kJson));
  if (!config.tokens.empty() && source.file && is_open_to_others(*source.file)) {
    spdlog::warn("{} holds tokens, but others than its owner can read or change it: chmod 600",
                 source.file->string());
  }
}

std::string url_of(const std::string& listen, int port) {
  const bool is_ipv6 = listen.find(':') != std::string::npos;
  return fmt::format("http://{}{}{}:{}", is_ipv6 ? "[" : "", listen, is_ipv6 ? "]" : "", port);
}

}  // namespace

Result<void> run_server_process(const ServerConfig& config, const ConfigSource& source,
                                const std::function<void(const std::string&)>& on_listening) {
  claim_resources();
  begin_process_log(config, source);
  StopSignals signals;
  auto started = HttpServer::start(config);
  if (!started) return started.error();
  const std::string url = url_of(config.listen, (*started)->port());
  const bool was_drained = run_until_stopped<HttpServer>(
      std::move(*started), signals, std::chrono::seconds(config.drain_timeout_s) + kLastWorkTime,
      [&source](HttpServer& server) { reload_tokens(server, source); }, store_sessions,
      [&] { on_listening(url); });
  if (!was_drained) return Error{ErrorCode::kInternal, "the listening socket failed", ""};
  spdlog::info("drained");
  return {};
}

}  // namespace cornerfix::server
