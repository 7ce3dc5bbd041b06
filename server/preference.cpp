#include "server/preference.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <utility>

namespace cornerfix::server {
namespace {

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t";
  const auto first = std::min(text.find_first_not_of(kBlanks), text.size());
  text.remove_prefix(first);
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

bool is_same_token(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

std::pair<std::string_view, std::string_view> name_and_value(std::string_view text) {
  const auto equals = std::min(text.find('='), text.size());
  std::string_view value = text.substr(std::min(equals + 1, text.size()));
  return {without_blanks(text.substr(0, equals)), without_blanks(value)};
}

/// Nothing for a text that is no number.
std::optional<std::chrono::seconds> delay_from(std::string_view text) {
  const bool is_number = !text.empty() && std::ranges::all_of(text, [](unsigned char c) {
    return std::isdigit(c) != 0;
  });
  if (!is_number) return std::nullopt;
  std::chrono::seconds::rep seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (error != std::errc{}) return kMaxWait;  // More than a number can hold.
  return std::min(std::chrono::seconds(seconds), kMaxWait);
}

}  // namespace

void add_preference(Preference& preference, std::string_view header) {
  while (!header.empty()) {
    const auto end = std::min(header.find(','), header.size());
    const std::string_view item = header.substr(0, end);
    // Parameters follow a semicolon; none of these has any.
    const std::string_view named = without_blanks(item.substr(0, item.find(';')));
    const auto [name, value] = name_and_value(named);
    if (is_same_token(named, "respond-async")) preference.respond_async = true;
    if (is_same_token(name, "wait") && !preference.wait) preference.wait = delay_from(value);
    header.remove_prefix(std::min(end + 1, header.size()));
  }
}

}  // namespace cornerfix::server
