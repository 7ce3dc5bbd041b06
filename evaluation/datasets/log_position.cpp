#include "evaluation/datasets/log_position.hpp"

#include <charconv>
#include <cmath>

namespace cornerfix::evaluation {

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

bool is_reached(const LogPosition& from, std::size_t index, double seconds) {
  if (const auto* wanted = std::get_if<std::size_t>(&from)) return index >= *wanted;
  return seconds >= std::get<LogTime>(from).seconds;
}

}  // namespace cornerfix::evaluation
