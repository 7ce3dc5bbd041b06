/// \file  Lines of the log with named values: for people as text, for programs as JSON.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace cornerfix::server {

enum class LogFormat {
  kText,  ///< "2026-01-31 12:00:00.000 info localized session=… robot=…"
  kJson,  ///< {"time":"2026-01-31T12:00:00.000Z","level":"info","event":"localized",…}
};

/// From now on, for all of the process' lines, on stderr. Lines that are plain text, as those of
/// spdlog::info(), are members "message" in JSON.
void begin_log(LogFormat format);

/// Escapes control characters, so that foreign text cannot begin a line of the log or command a
/// terminal.
[[nodiscard]] std::string printable(std::string_view text);

using LogValue = std::variant<std::string_view, double, std::int64_t>;
using LogFields = std::initializer_list<std::pair<std::string_view, LogValue>>;

/// One line. Empty texts are left out. Any threads may call.
void log_event(std::string_view event, LogFields fields);
void log_warning(std::string_view event, LogFields fields);

/// What begin_log() writes between level and end of a line; for tests.
[[nodiscard]] std::string log_text(LogFormat format, std::string_view event, LogFields fields);

}  // namespace cornerfix::server
