/// \file  What the commands of `cornerfix` share: how they join the command line and how they end.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include <cornerfix/result.hpp>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::cli {

constexpr int kDone = 0;
constexpr int kCouldNot = 1;
constexpr int kWrongUse = 2;

/// Prints on stderr why something could not be done; returns kCouldNot.
int fail(const Error& error);

/// Prints a warning about `where` on stderr, unless `what` is empty.
void warn(const std::string& where, const std::string& what);

/// Reads a log into memory, with a progress bar and with warnings. An error as well when most of
/// its scans cannot be used. \param stride  n keeps every n-th scan, from the first.
[[nodiscard]] Result<evaluation::RecordedLog> read_whole_log(
    const std::string& path, const evaluation::LogSelection& selection, std::size_t stride = 1);

/// Whole or not at all: what was there stays until the last byte is written.
[[nodiscard]] Result<void> write_file(const std::string& path, const std::string& bytes);

/// LOG, a recorded run: a file or the directory of a bag.
CLI::Option* add_log(CLI::App& command, std::string& log);

/// --lidar, --odom, --height and --scan-time.
void add_selection(CLI::App& command, evaluation::LogSelection& selection);

/// A finite number above 0, or not below 0. CLI11's own print the largest double in full.
[[nodiscard]] CLI::Validator above_zero();
[[nodiscard]] CLI::Validator not_below_zero();

/// A name that a map may have.
[[nodiscard]] CLI::Validator map_name();

/// NAME, of a map.
void add_map_name(CLI::App& command, std::string& name);

// Each adds its command to `app`. Parsing a command line runs its command, which leaves its exit
// code in `exit_code`; wrong use is thrown as CLI::ParseError.
void add_backup_command(CLI::App& app, int& exit_code);
void add_database_command(CLI::App& app, int& exit_code);
void add_load_command(CLI::App& app, int& exit_code);
void add_map_command(CLI::App& app, int& exit_code);
void add_replay_command(CLI::App& app, int& exit_code);
void add_slam_command(CLI::App& app, int& exit_code);
void add_ros2_command(CLI::App& app, int& exit_code);
void add_serve_command(CLI::App& app, int& exit_code);
void add_evaluate_command(CLI::App& app, int& exit_code);
void add_scene_command(CLI::App& app, int& exit_code);
void add_simulate_command(CLI::App& app, int& exit_code);
void add_token_command(CLI::App& app, int& exit_code);

}  // namespace cornerfix::cli
