#include <malloc.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cli/command.hpp"
#include "server/environment.hpp"
#include "server/event_log.hpp"
#include "server/http_server.hpp"
#include "server/server_config.hpp"
#include "server/settings.hpp"

namespace cornerfix::cli {

namespace {

using server::HttpServer;
using server::ServerConfig;
using server::Setting;

/// Robots of a whole fleet run on many threads; more heaps than this only cost memory.
constexpr int kMaxHeaps = 4;
/// Buffers from this size on go back to the system as soon as they are let go. By default the C
/// library keeps ever larger ones, and what a large map needed while it was loaded would stay.
constexpr int kMappedBufferBytes = 1 << 20;
/// How often freed memory goes back to the system [s]. A session that searches needs several times
/// what it needs later, in pieces between those that others keep.
constexpr int kTrimInterval = 10;
/// On top of the drain time, for batches that are being worked on: then the process ends anyway.
/// What was acknowledged is then in the database.
constexpr std::chrono::seconds kLastBatchTime{2};

struct ServeArguments {
  std::optional<std::filesystem::path> config;
  std::vector<server::ConfigOverride> overrides;  ///< Flags; once they are read, variables before.
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
    spdlog::warn("SIGHUP reloads the tokens of the configuration file, but there is none: ignored");
    return;
  }
  auto config = server::load_config(arguments.config, arguments.overrides);
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
        store_sessions(server);
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
  /// The next signal. Meanwhile, memory that is free goes back to the system.
  static int wait() {
    const sigset_t signals = handled_signals();
    const timespec interval{.tv_sec = kTrimInterval, .tv_nsec = 0};
    for (;;) {
      const int signal = sigtimedwait(&signals, nullptr, &interval);
      if (signal > 0) return signal;
      malloc_trim(0);
    }
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
  store_sessions(server);
  if (!was_drained) return fail({ErrorCode::kInternal, "the listening socket failed", ""});
  spdlog::info("drained");
  return kDone;
}

/// Adds the environment, which flags override.
void add_environment(ServeArguments& arguments) {
  server::Environment environment = server::read_environment(environ);
  for (const std::string& name : environment.unknown) warn(name, "no such setting; ignored");
  if (!arguments.config) arguments.config = environment.config_file;
  arguments.overrides.insert(arguments.overrides.begin(), environment.overrides.begin(),
                             environment.overrides.end());
}

int run_serve(ServeArguments& arguments) {
  add_environment(arguments);
  const auto config = server::load_config(arguments.config, arguments.overrides);
  if (config) return serve(*config, arguments);
  fail(config.error());
  return config.error().code == ErrorCode::kNotFound ? kCouldNot : kWrongUse;
}

std::string help_of(const Setting& setting) {
  std::string help = setting.meaning;
  if (!setting.default_value.empty()) help += " (" + setting.default_value + ")";
  return help + "; " + setting.variable();
}

void add_setting(CLI::App& command, const Setting& setting, ServeArguments& arguments) {
  const std::string flag = setting.flag();
  const auto add = [&arguments, key = setting.key, flag](const std::string& text) {
    arguments.overrides.push_back({key, text, flag});
  };
  if (setting.kind == Setting::Kind::kSwitch) {
    command.add_flag_function(
        flag, [add](std::int64_t count) { add(count > 0 ? "true" : "false"); }, help_of(setting));
    return;
  }
  const bool is_integer = setting.kind == Setting::Kind::kInteger;
  const bool is_list = setting.kind == Setting::Kind::kNames;
  // The database has the name that it has in every command, too.
  const std::string names = setting.key == "database" ? "--db," + flag : flag;
  command.add_option_function<std::string>(names, add, help_of(setting))
      ->type_name(is_integer ? "N"
                  : is_list  ? "NAME,..."
                             : "TEXT");
}

}  // namespace

void add_serve_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ServeArguments>();
  CLI::App* command = app.add_subcommand("serve", "Run the server until SIGTERM or Ctrl-C");
  command
      ->add_option("--config", arguments->config,
                   "JSON file with any of the settings; CORNERFIX_CONFIG")
      ->check(CLI::ExistingFile);
  std::string without_flag;
  for (const Setting& setting : server::settings()) {
    if (!setting.flag().empty()) {
      add_setting(*command, setting, *arguments);
    } else {
      without_flag += "\n  " + setting.variable() + "  " + setting.meaning;
    }
  }
  command->footer(
      "Flags override variables of the environment, which override the file. An empty variable is "
      "not set.\nSettings without a flag, since every user of a machine sees the arguments of "
      "programs:" +
      without_flag);
  command->callback([arguments, &exit_code] { exit_code = run_serve(*arguments); });
}

}  // namespace cornerfix::cli
