#include <malloc.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "cli/command.hpp"
#include "server/event_log.hpp"
#include "server/http_server.hpp"
#include "server/server_config.hpp"

namespace cornerfix::cli {

namespace {

using server::HttpServer;
using server::ServerConfig;
using server::ServerFlags;

/// Robots of a whole fleet run on many threads; more heaps than this only cost memory.
constexpr int kMaxHeaps = 4;
/// Buffers from this size on go back to the system as soon as they are let go. By default the C
/// library keeps ever larger ones, and what a large map needed while it was loaded would stay.
constexpr int kMappedBufferBytes = 1 << 20;
/// On top of the drain time, for batches that are being worked on: then the process ends anyway.
/// What was acknowledged is in the database.
constexpr std::chrono::seconds kLastBatchTime{2};

struct ServeArguments {
  ServerFlags flags;
  std::optional<std::filesystem::path> config;
};

sigset_t handled_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  return signals;
}

/// Takes over the tokens of the configuration file. When it cannot be used, the old ones stay.
void reload_tokens(HttpServer& server, const ServeArguments& arguments) {
  if (!arguments.config) {
    spdlog::warn("SIGHUP reloads the tokens of --config FILE, but there is none: ignored");
    return;
  }
  auto config = server::load_config(arguments.config, arguments.flags);
  if (!config) {
    spdlog::error("the tokens stay as they were: {}{}{}", config.error().message,
                  config.error().field.empty() ? "" : " at ", config.error().field);
    return;
  }
  spdlog::info("reloaded {} tokens", config->tokens.size());
  server.set_tokens(std::move(config->tokens));
}

/// Drains the server when a stop signal comes, and reloads tokens at SIGHUP. Every thread made
/// after this one leaves these signals alone.
class Signals {
 public:
  Signals() {
    const sigset_t signals = handled_signals();
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  }

  void handle(HttpServer& server, const ServeArguments& arguments, std::chrono::seconds stop_time) {
    thread_ = std::thread([this, &server, &arguments, stop_time] {
      while (wait() == SIGHUP) reload_tokens(server, arguments);
      server.drain();
      std::unique_lock lock(mutex_);
      if (!ended_.wait_for(lock, stop_time, [this] { return has_ended_; })) {
        spdlog::warn("some requests are still in work; leaving them");
        spdlog::shutdown();
        std::_Exit(kDone);
      }
    });
  }

  /// To be called when the server has ended, for any reason.
  void end() {
    {
      const std::lock_guard lock(mutex_);
      has_ended_ = true;
    }
    ended_.notify_all();
    // The thread waits for just this signal, which is blocked everywhere else.
    pthread_kill(thread_.native_handle(), SIGTERM);  // NOLINT(bugprone-bad-signal-to-kill-thread)
    thread_.join();
  }

 private:
  static int wait() {
    const sigset_t signals = handled_signals();
    int signal = 0;
    sigwait(&signals, &signal);
    return signal;
  }

  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
};

/// Connections need descriptors, and the usual limit of 1,024 is far below what the loop can hold.
void raise_descriptor_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

int serve(const ServerConfig& config, const ServeArguments& arguments) {
  mallopt(M_ARENA_MAX, kMaxHeaps);
  mallopt(M_MMAP_THRESHOLD, kMappedBufferBytes);
  const bool is_terminal = ::isatty(STDERR_FILENO) == 1;
  server::begin_log(config.log_format.value_or(is_terminal ? server::LogFormat::kText
                                                           : server::LogFormat::kJson));
  raise_descriptor_limit();
  if (!config.tokens.empty() && arguments.config && server::is_open_to_others(*arguments.config)) {
    spdlog::warn("{} holds tokens, but others than its owner can read or change it: chmod 600",
                 arguments.config->string());
  }
  Signals signals;
  auto started = HttpServer::start(config);
  if (!started) return fail(started.error());
  HttpServer& server = **started;
  signals.handle(server, arguments, std::chrono::seconds(config.drain_timeout_s) + kLastBatchTime);
  const bool is_ipv6 = config.listen.find(':') != std::string::npos;
  std::printf("listening on http://%s%s%s:%d\n", is_ipv6 ? "[" : "", config.listen.c_str(),
              is_ipv6 ? "]" : "", server.port());
  std::fflush(stdout);
  const bool was_drained = server.run();
  signals.end();
  if (!was_drained) return fail({ErrorCode::kInternal, "the listening socket failed", ""});
  spdlog::info("drained");
  return kDone;
}

int run_serve(const ServeArguments& arguments) {
  const auto config = server::load_config(arguments.config, arguments.flags);
  if (config) return serve(*config, arguments);
  fail(config.error());
  return config.error().code == ErrorCode::kNotFound ? kCouldNot : kWrongUse;
}

}  // namespace

void add_serve_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ServeArguments>();
  CLI::App* command = app.add_subcommand("serve", "Run the server until SIGTERM or Ctrl-C");
  command->add_option("--db", arguments->flags.database,
                      "SQLite file, made when it does not exist");
  command->add_option("--listen", arguments->flags.listen, "Address to bind (127.0.0.1)");
  command->add_option("--port", arguments->flags.port, "Port; 0 takes a free one (8080)");
  command->add_option("--config", arguments->config, "JSON file with any of the settings")
      ->check(CLI::ExistingFile);
  command->add_flag("--allow-insecure-listen", arguments->flags.allow_insecure_listen,
                    "Bind to more than loopback without any tokens");
  command->callback([arguments, &exit_code] { exit_code = run_serve(*arguments); });
}

}  // namespace cornerfix::cli
