/// \file  The whole command line of `cornerfix`.
#pragma once

namespace cornerfix::cli {

/// Parses and runs a command. Returns the process's exit code: 0 done, 1 it could not, 2 wrong use.
/// The reason is then on stderr.
[[nodiscard]] int run_command_line(int argc, const char* const* argv);

}  // namespace cornerfix::cli
