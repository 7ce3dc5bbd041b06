/// \file  `cornerfix-bench`: the paper's experiments, and Cornerfix beside its rivals on the same
/// work. scripts/bench.sh runs them all and makes the report.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/experiments/contestants.hpp"
#include "bench/experiments/experiment.hpp"

int main(int argc, char** argv) {
  CLI::App app("Repeats the paper's experiments and puts Cornerfix beside its rivals.");
  app.require_subcommand(1);
  app.option_defaults()->always_capture_default();
  cornerfix::bench::add_corners_experiment(app);
  cornerfix::bench::add_matching_experiment(app);
  cornerfix::bench::add_worlds_experiment(app);
  cornerfix::bench::add_robots_experiment(app);
  cornerfix::bench::add_tracking_experiment(app);
  cornerfix::bench::add_many_maps_experiment(app);
  cornerfix::bench::add_map_ranking_experiment(app);
  app.add_subcommand("methods", "Names of the methods that this build can compare")->callback([] {
    for (const std::string& name : cornerfix::bench::contestant_names())
      std::printf("%s\n", name.c_str());
  });
  CLI11_PARSE(app, argc, argv);
  return 0;
}
