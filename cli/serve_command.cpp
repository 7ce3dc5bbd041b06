#include <malloc.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

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

#include "cli/command.hpp"
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
/// A client that neither sends nor reads cannot keep the server from going down.
constexpr std::chrono::seconds kDrainTime{20};

struct ServeArguments {
  ServerFlags flags;
  std::optional<std::filesystem::path> config;
};

sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  return signals;
}

/// Drains the server when a stop signal comes. Every thread made after this one is spared them.
class StopSignals {
 public:
  StopSignals() {
    const sigset_t signals = stop_signals();
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  }

  void drain_on_signal(HttpServer& server) {
    thread_ = std::thread([this, &server] {
      const sigset_t signals = stop_signals();
      int signal = 0;
      sigwait(&signals, &signal);
      server.drain();
      std::unique_lock lock(mutex_);
      if (!ended_.wait_for(lock, kDrainTime, [this] { return has_ended_; })) {
        spdlog::warn("some clients did not let go; leaving them");
        spdlog::shutdown();
        std::_Exit(kDone);
      }
    });
  }

  /// To be called when the server has ended, for whatever reason.
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
  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
};

int serve(const ServerConfig& config) {
  mallopt(M_ARENA_MAX, kMaxHeaps);
  mallopt(M_MMAP_THRESHOLD, kMappedBufferBytes);
  spdlog::set_default_logger(spdlog::stderr_logger_mt("cornerfix"));
  StopSignals signals;
  auto started = HttpServer::start(config);
  if (!started) return fail(started.error());
  HttpServer& server = **started;
  signals.drain_on_signal(server);
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
  if (config) return serve(*config);
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
