/// \file  A place in a log where a robot is switched on.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "cli/log_reader.hpp"

namespace cornerfix::cli {

/// Seconds after the first scan.
struct LogTime {
  double seconds = 0.0;
};

/// The index of a scan, or a time.
using LogPosition = std::variant<std::size_t, LogTime>;

/// "120" is a scan, "30s" or "1.5s" a time; nothing for anything else.
[[nodiscard]] std::optional<LogPosition> parse_log_position(std::string_view text);

/// The scans from there on; empty when it lies behind the last.
[[nodiscard]] std::span<const LogScan> scans_from(std::span<const LogScan> scans,
                                                  const LogPosition& from);

}  // namespace cornerfix::cli
