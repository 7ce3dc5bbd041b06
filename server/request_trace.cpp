#include "server/request_trace.hpp"

#include <algorithm>
#include <cstddef>

namespace cornerfix::server {
namespace {

constexpr std::size_t kMaxRequestId = 128;
// 00-TRACE-PARENT-FLAGS
constexpr std::size_t kTraceBegin = 3;
constexpr std::size_t kTraceLength = 32;
constexpr std::size_t kParentBegin = 36;
constexpr std::size_t kParentLength = 16;
constexpr std::size_t kFlagsBegin = 53;
constexpr std::size_t kLength = 55;

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_lower_hex(char c) { return is_digit(c) || (c >= 'a' && c <= 'f'); }
bool is_id_character(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '_' ||
         c == '-';
}

bool is_hex_id(std::string_view text) {
  return std::ranges::all_of(text, is_lower_hex) &&
         std::ranges::any_of(text, [](char c) { return c != '0'; });
}

}  // namespace

bool is_request_id(std::string_view text) {
  return !text.empty() && text.size() <= kMaxRequestId &&
         std::ranges::all_of(text, is_id_character);
}

bool is_traceparent(std::string_view text) {
  return text.size() == kLength && text.starts_with("00-") && text[kParentBegin - 1] == '-' &&
         text[kFlagsBegin - 1] == '-' && is_hex_id(text.substr(kTraceBegin, kTraceLength)) &&
         is_hex_id(text.substr(kParentBegin, kParentLength)) &&
         std::ranges::all_of(text.substr(kFlagsBegin), is_lower_hex);
}

std::string_view trace_id_of(std::string_view traceparent) {
  return is_traceparent(traceparent) ? traceparent.substr(kTraceBegin, kTraceLength)
                                     : std::string_view{};
}

}  // namespace cornerfix::server
