/// \file  Numbers in sentences.
#pragma once

#include <cstdio>
#include <string>

namespace cornerfix::api {

/// As std::snprintf.
template <typename... Values>
[[nodiscard]] std::string format(const char* pattern, Values... values) {
  const int size = std::snprintf(nullptr, 0, pattern, values...);
  std::string text(static_cast<std::size_t>(size), '\0');
  std::snprintf(text.data(), text.size() + 1, pattern, values...);
  return text;
}

}  // namespace cornerfix::api
