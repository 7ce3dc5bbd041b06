/// \file  What must be known of a whole log before its scans can be used one by one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

struct LogSurvey {
  std::size_t scans = 0;
  std::size_t posed_scans = 0;      ///< With a reference pose.
  std::size_t posed_key_scans = 0;  ///< In a log that marks key scans, those with a pose.
  std::string remarks;              ///< What a person should know of the log; may be empty.

  /// How many scans lie in the first `share` of the log.
  [[nodiscard]] std::size_t scans_in(double share) const {
    return static_cast<std::size_t>(static_cast<double>(scans) * share);
  }
  /// How many posed scans lie in the first `share` of the log.
  [[nodiscard]] std::size_t posed_scans_in(double share) const {
    return static_cast<std::size_t>(static_cast<double>(posed_scans) * share);
  }
};

/// An error as well when most of its scans cannot be used. Reads the whole log and holds none of
/// it. `stride` n keeps every n-th scan, from the first. `progress` is called with the share of the
/// file read, in [0, 1], and may be empty.
[[nodiscard]] Result<LogSurvey> survey_log(const std::filesystem::path& path,
                                           const LogSelection& selection, std::size_t stride = 1,
                                           const std::function<void(double)>& progress = {});

}  // namespace cornerfix::evaluation
