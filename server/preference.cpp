#include "server/preference.hpp"

#include <algorithm>
#include <cctype>

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

}  // namespace

bool prefers_async(std::string_view header) {
  while (!header.empty()) {
    const auto end = std::min(header.find(','), header.size());
    const std::string_view preference = header.substr(0, end);
    // Parameters follow a semicolon; respond-async has none.
    const std::string_view name = without_blanks(preference.substr(0, preference.find(';')));
    if (is_same_token(name, "respond-async")) return true;
    header.remove_prefix(std::min(end + 1, header.size()));
  }
  return false;
}

}  // namespace cornerfix::server
