#include "cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include "cli/command.hpp"

namespace cornerfix::cli {

namespace {

/// The word that stands where a command should; empty when none does.
std::string unknown_command(const CLI::App& app) {
  const CLI::App* innermost = &app;
  for (auto chosen = app.get_subcommands(); !chosen.empty(); chosen = innermost->get_subcommands())
    innermost = chosen.front();
  const auto words = innermost->remaining();
  const bool needs_command = innermost->get_require_subcommand_min() > 0;
  return needs_command && !words.empty() ? words.front() : std::string();
}

/// What was printed may not have been written: the disk is full, or the reader is gone.
int finish_output() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return kDone;
  const std::string reason = errno == 0 ? "" : std::string(": ") + std::strerror(errno);
  return fail({ErrorCode::kUnavailable, "cannot be written" + reason, "standard output"});
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  CLI::App app("Cornerfix finds the pose of robots with a 2D lidar in stored maps.");
  app.name("cornerfix");
  app.require_subcommand(1);
  app.fallthrough(false);
  app.set_version_flag("--version", "cornerfix " CORNERFIX_VERSION, "Print the version and exit");
  app.footer("Exit codes: 0 done, 1 it could not, 2 wrong use.");
  int exit_code = kDone;
  add_load_command(app, exit_code);
  add_map_command(app, exit_code);
  add_replay_command(app, exit_code);
  add_serve_command(app, exit_code);
  add_evaluate_command(app, exit_code);
  add_simulate_command(app, exit_code);
  add_scene_command(app, exit_code);
  add_slam_command(app, exit_code);
  add_backup_command(app, exit_code);
  add_database_command(app, exit_code);
  add_ros2_command(app, exit_code);
  add_token_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RequiredError& error) {
    const std::string word = unknown_command(app);
    if (word.empty()) {
      app.exit(error);
    } else {
      app.exit(CLI::ParseError("there is no command " + word, CLI::ExitCodes::RequiredError));
    }
    return kWrongUse;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? finish_output() : kWrongUse;  // --help and --version, too.
  } catch (const std::exception& error) {
    // No memory left, or an answer of a shape that no Cornerfix server gives.
    return fail({ErrorCode::kInternal, error.what(), ""});
  }
  return exit_code == kDone ? finish_output() : exit_code;
}

}  // namespace cornerfix::cli
