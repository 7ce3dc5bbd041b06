#include "cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <exception>

#include "cli/command.hpp"

namespace cornerfix::cli {

int run_command_line(int argc, const char* const* argv) {
  CLI::App app("Cornerfix tells a robot with a 2D lidar where it is in a known building.");
  app.name("cornerfix");
  app.require_subcommand(1);
  app.fallthrough(false);
  app.set_version_flag("--version", "cornerfix " CORNERFIX_VERSION, "Print the version and exit");
  app.footer("Exit codes: 0 done, 1 it could not, 2 wrong use.");
  int exit_code = kDone;
  add_map_command(app, exit_code);
  add_replay_command(app, exit_code);
  add_serve_command(app, exit_code);
  add_evaluate_command(app, exit_code);
  add_simulate_command(app, exit_code);
  add_slam_command(app, exit_code);
  add_backup_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongUse;  // --help and --version, too.
  } catch (const std::exception& error) {
    // No memory left, or an answer of a shape that no Cornerfix server gives.
    return fail({ErrorCode::kInternal, error.what(), ""});
  }
  return exit_code;
}

}  // namespace cornerfix::cli
