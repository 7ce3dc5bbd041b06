/// \file  Straightens the scans of a log by its odometry.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// Takes the scans of a log in its order. One thread at a time.
class ScanStraightener {
 public:
  /// By the motion to the scan after this one, or else from the one before: of odometry, or else of
  /// the reference poses. Leaves a scan as it is that was taken at once. `after` may be null.
  void straighten(LogScan& scan, const LogScan* after);

  /// How many scans could not be straightened, for people.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  std::optional<LogScan> before_;  ///< Its stamp and poses.
  std::size_t crooked_ = 0;
  std::size_t too_long_ = 0;  ///< Scans whose time_increment is no time.
  std::string first_too_long_;
};

}  // namespace cornerfix::evaluation
