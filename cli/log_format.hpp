/// \file  Tells the kinds of logs apart.
#pragma once

#include <filesystem>

#include <cornerfix/result.hpp>

namespace cornerfix::cli {

enum class LogFormat {
  kJsonLines,
  kCarmen,
  kRos1Bag,    ///< Bag format 2.0.
  kMcap,       ///< With messages of ROS 1 or ROS 2.
  kSqliteBag,  ///< ROS 2's .db3.
};

/// By what the file begins with, then by its extension (.jsonl, .log, .clf, .gfs, also with .gz),
/// then by its first line.
[[nodiscard]] Result<LogFormat> detect_log_format(const std::filesystem::path& path);

}  // namespace cornerfix::cli
