/// \file  Cornerfix and its rivals, ready to be switched on in one mapped building.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <cornerfix/localization_map.hpp>

#include "evaluation/metrics/localization_score.hpp"

namespace cornerfix::bench {

/// The building as all contestants know it.
struct MappedBuilding {
  std::string name;
  LocalizationMapPtr map;             ///< With line-intersection corners: the default.
  LocalizationMapPtr vfp_map;         ///< With the paper's corners.
  std::vector<PosedScan> grid_scans;  ///< What Cartographer would put into its grid.
};

/// Makes both maps of keyframes.
[[nodiscard]] MappedBuilding map_building(std::string name,
                                          const std::vector<PosedScan>& key_frames,
                                          std::vector<PosedScan> grid_scans);

/// What each scan cost that a robot worked on, of all robots of one contestant.
struct ScanTimes {
  std::vector<double> searching_ms;  ///< Until localized.
  std::vector<double> tracking_ms;   ///< After it.
  std::size_t robot_bytes = 0;       ///< The most that a robot kept for itself.
};

/// One method in one building. Robots it makes must not outlive it.
struct Contestant {
  std::string method;
  std::size_t map_bytes = 0;
  std::function<evaluation::ScoredRobot(const evaluation::LogScan& first, ScanTimes& times)>
      switch_on;
};

/// Names that make_contestant() knows in this build, in the order of reports.
[[nodiscard]] std::vector<std::string> contestant_names();

/// `name` must be one of contestant_names(). Made one at a time, since maps are large.
[[nodiscard]] Contestant make_contestant(const std::string& name, const MappedBuilding& building);

}  // namespace cornerfix::bench
