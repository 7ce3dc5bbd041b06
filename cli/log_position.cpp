#include "cli/log_position.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace cornerfix::cli {

namespace {

template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

std::optional<LogPosition> parse_log_position(std::string_view text) {
  if (text.ends_with('s')) {
    const auto seconds = parse_number<double>(text.substr(0, text.size() - 1));
    if (!seconds || !std::isfinite(*seconds) || *seconds < 0.0) return std::nullopt;
    return LogTime{*seconds};
  }
  return parse_number<std::size_t>(text);
}

std::span<const LogScan> scans_from(std::span<const LogScan> scans, const LogPosition& from) {
  if (const auto* index = std::get_if<std::size_t>(&from)) {
    return scans.subspan(std::min(*index, scans.size()));
  }
  if (scans.empty()) return scans;
  const double stamp = scans.front().scan.stamp + std::get<LogTime>(from).seconds;
  const auto first = std::find_if(scans.begin(), scans.end(), [stamp](const LogScan& scan) {
    return scan.scan.stamp >= stamp;
  });
  return scans.subspan(static_cast<std::size_t>(first - scans.begin()));
}

}  // namespace cornerfix::cli
