/// \file  The commands of `cornerfix map` that have files of their own.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace cornerfix::cli {

/// --db instead of --server, --token and --print-curl, which were added before.
void add_database_option(CLI::App& command, std::string& database);

// Each adds its command to `map`, as those of command.hpp do.
void add_map_build_command(CLI::App& map, int& exit_code);
void add_map_import_command(CLI::App& map, int& exit_code);
void add_map_export_command(CLI::App& map, int& exit_code);
void add_map_restore_command(CLI::App& map, int& exit_code);
void add_map_report_command(CLI::App& map, int& exit_code);

}  // namespace cornerfix::cli
