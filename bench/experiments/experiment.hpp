/// \file  The experiments of the paper, a command each: how they join the command line of
/// `cornerfix-bench`.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>

#include <cornerfix/result.hpp>

namespace cornerfix::bench {

// Parsing a command line runs its experiment, which writes its tables as CSV into a folder.
void add_corners_experiment(CLI::App& app);      ///< Section 4.2, tables 1-3, figure 7.
void add_matching_experiment(CLI::App& app);     ///< Section 4.3, figure 8.
void add_worlds_experiment(CLI::App& app);       ///< Section 4.4, figures 9-11.
void add_robots_experiment(CLI::App& app);       ///< Section 4.5, figure 12, tables 4-5.
void add_tracking_experiment(CLI::App& app);     ///< What following a robot costs.
void add_many_maps_experiment(CLI::App& app);    ///< A robot without a given map.
void add_map_ranking_experiment(CLI::App& app);  ///< How maps are ranked before they are searched.

/// The folder for the tables: an option that all experiments have.
inline void add_out_option(CLI::App& command, std::filesystem::path& out) {
  command.add_option("--out", out, "Folder for the tables")->check(CLI::ExistingDirectory);
}

/// The value, or the end of the program with the reason.
template <typename T>
T value_or_exit(Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "cornerfix-bench: %s: %s\n", result.error().field.c_str(),
               result.error().message.c_str());
  std::exit(1);
}

}  // namespace cornerfix::bench
