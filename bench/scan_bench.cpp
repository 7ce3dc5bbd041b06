/// \file  Time of a whole scan, from its ranges to the answer, one thread:
/// `cornerfix_pipeline_bench --benchmark_filter=Scan`.
///
/// Willow Garage is mapped by a simulated run. Robots with 1080 beams, odometry and people about
/// them are then started all along another one. The counters give processor time per scan while
/// searching and while tracking [ms], and how many robots were localized correctly. The time column
/// is that of all scans together.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/map_image.hpp>

#include "evaluation/metrics/localization_score.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/simulation/run_simulator.hpp"

namespace cornerfix::evaluation {
namespace {

constexpr std::size_t kBeams = 1080;

template <typename T>
T value_of(Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "scan_bench: %s\n", result.error().message.c_str());
  std::exit(1);
}

struct Runs {
  Evaluation mapped;
  RecordedLog robot;
};

Runs simulate_runs() {
  const OccupancyGrid willow = value_of(read_map_files(CORNERFIX_WILLOW_MAP));
  const RecordedLog mapping = value_of(simulate_run(
      willow, {.beams = kBeams, .drift = 0.0, .length_m = 600.0, .step_m = 0.3, .seed = 1}));
  return {
      map_from(mapping, mapping.scans.size(), {}),
      value_of(simulate_run(willow, {.beams = kBeams, .people = 3, .length_m = 200.0, .seed = 2}))};
}

void count_times(benchmark::State& state, const std::string& name,
                 const std::vector<double>& times_ms) {
  state.counters[name + "_scans"] = static_cast<double>(times_ms.size());
  state.counters[name + "_p50_ms"] = percentile(times_ms, 0.50);
  state.counters[name + "_p95_ms"] = percentile(times_ms, 0.95);
}

void scan(benchmark::State& state, Method method) {
  static const Runs runs = simulate_runs();
  EvaluationOptions options;
  options.starts = 50;
  options.batch = 1;
  options.localizer.method = method;
  std::vector<StartRecord> records;
  for (auto _ : state) {
    records = evaluate(runs.robot, 0, {runs.mapped.map}, 0, runs.mapped.mapping_positions, options,
                       nullptr);
  }
  std::vector<double> searching_ms;
  std::vector<double> tracking_ms;
  for (const StartRecord& record : records) {
    searching_ms.insert(searching_ms.end(), record.searching_ms.begin(), record.searching_ms.end());
    tracking_ms.insert(tracking_ms.end(), record.tracking_ms.begin(), record.tracking_ms.end());
  }
  state.counters["robots"] = static_cast<double>(records.size());
  state.counters["found"] =
      static_cast<double>(std::ranges::count(records, Verdict::kCorrect, &StartRecord::verdict));
  count_times(state, "search", searching_ms);
  count_times(state, "track", tracking_ms);
}
BENCHMARK_CAPTURE(scan, indexed, Method::kIndexed)
    ->Name("Scan/indexed")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scan, rma, Method::kRma)
    ->Name("Scan/rma")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cornerfix::evaluation
