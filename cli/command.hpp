/// \file  What the commands of `cornerfix` share: how they join the command line and how they end.
#pragma once

#include <CLI/CLI.hpp>

#include <cornerfix/result.hpp>

namespace cornerfix::cli {

constexpr int kDone = 0;
constexpr int kCouldNot = 1;
constexpr int kWrongUse = 2;

/// Says on stderr why something could not be done; returns kCouldNot.
int fail(const Error& error);

// Each adds its command to `app`. Parsing a command line runs its command, which leaves its exit
// code in `exit_code`; wrong use is thrown as CLI::ParseError.
void add_map_command(CLI::App& app, int& exit_code);
void add_replay_command(CLI::App& app, int& exit_code);
void add_slam_command(CLI::App& app, int& exit_code);
void add_serve_command(CLI::App& app, int& exit_code);
void add_evaluate_command(CLI::App& app, int& exit_code);
void add_simulate_command(CLI::App& app, int& exit_code);

}  // namespace cornerfix::cli
