/// \file  A fleet of robots against one server, paced like real ones.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include <cornerfix/result.hpp>

#include "clients/cpp/http_request.hpp"
#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::client {

/// Robots post batches on a schedule of their own, whether or not answers come in time. In this
/// open loop, a slow server shows as late answers and not as little load.
struct FleetOptions {
  ServerAddress server;
  std::string map;  ///< Empty: robots search all maps.
  std::string robot_prefix = "load";
  std::size_t robots = 100;    ///< > 0.
  double batches_per_s = 1.0;  ///< Per robot; > 0.
  std::size_t batch = 5;       ///< Scans per batch; > 0.
  double searching = 0.0;      ///< Share of robots that begin anew once localized; 0 to 1.
  double ramp_s = 20.0;        ///< Until all robots are on; >= 0.
  double seconds = 30.0;       ///< That all of them are on; > 0.
};

/// What became of the batches that were due.
struct BatchTally {
  std::size_t offered = 0;                    ///< Were due.
  std::size_t served = 0;                     ///< Were answered with 200.
  std::size_t late = 0;                       ///< Of these, after the robot's next batch was due.
  std::size_t shed = 0;                       ///< Were answered with 429 or 503.
  std::size_t failed = 0;                     ///< Were answered otherwise, or not at all.
  std::size_t localized = 0;                  ///< Of the served ones.
  std::vector<double> latencies_ms;           ///< Of the served ones, from when the batch was due.
  std::map<int, std::size_t> other_statuses;  ///< Of the failed ones; 0: no answer.

  void add(const BatchTally& other);
};

struct FleetReport {
  BatchTally tracking;        ///< Of the robots that stay localized, while all were on.
  BatchTally searching;       ///< Of the others.
  BatchTally ramp;            ///< Of all, before.
  double server_cpu_s = 0.0;  ///< Of the server while all were on; 0 when it does not say.
};

/// Robots go along `log` and back again, each from another place in it. Sessions are deleted at the
/// end. A robot whose batch was shed posts its next scans with the same sequence.
[[nodiscard]] Result<FleetReport> run_fleet(const FleetOptions& options,
                                            const evaluation::RecordedLog& log);

}  // namespace cornerfix::client
