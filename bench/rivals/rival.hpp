/// \file  What all rivals have in common: scans of one robot in, its pose in one map out.
#pragma once

#include <cstddef>
#include <optional>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix::bench {

/// What a rival says after a scan.
struct RivalAnswer {
  std::optional<Pose2> T_map_base_link;  ///< Nothing while it does not know.
  bool updated = true;  ///< False when it only waited for the robot to move: such a scan costs
                        ///< nothing and is not timed.
};

/// Finds one robot in one map and follows it. Deterministic; one thread at a time.
class Rival {
 public:
  Rival() = default;
  virtual ~Rival() = default;
  Rival(const Rival&) = delete;
  Rival& operator=(const Rival&) = delete;

  [[nodiscard]] virtual RivalAnswer process(const RobotScan& scan) = 0;

  /// What this robot keeps in memory, the map not counted.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
};

}  // namespace cornerfix::bench
