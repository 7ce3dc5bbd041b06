/// \file  Recognizes the kinds of logs.
#pragma once

#include <filesystem>

#include <cornerfix/result.hpp>

namespace cornerfix::evaluation {

enum class LogFormat {
  kJsonLines,
  kCarmen,
  kBag,  ///< Of ROS 1 or ROS 2, or a directory with the files of one.
};

/// By what the file begins with, then by its extension (.jsonl, .log, .clf, .gfs, also with .gz),
/// then by its first line.
[[nodiscard]] Result<LogFormat> detect_log_format(const std::filesystem::path& path);

}  // namespace cornerfix::evaluation
