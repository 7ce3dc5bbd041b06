/// \file  A place in a log where a robot is switched on.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <variant>

namespace cornerfix::evaluation {

/// Seconds after the first scan.
struct LogTime {
  double seconds = 0.0;
};

/// The index of a scan, or a time.
using LogPosition = std::variant<std::size_t, LogTime>;

/// "120" is a scan, "30s" or "1.5s" a time; nothing for anything else.
[[nodiscard]] std::optional<LogPosition> parse_log_position(std::string_view text);

/// Whether the `index`th scan, this long after the first one, lies there or behind.
[[nodiscard]] bool is_reached(const LogPosition& from, std::size_t index, double seconds);

}  // namespace cornerfix::evaluation
