#include "server/request_head.hpp"

#include <strings.h>

#include <algorithm>
#include <charconv>
#include <utility>

namespace cornerfix::server {
namespace {

constexpr std::string_view kWhitespace = " \t";

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return a.size() == b.size() && strncasecmp(a.data(), b.data(), a.size()) == 0;
}

std::string_view stripped(std::string_view text) {
  const auto first = text.find_first_not_of(kWhitespace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kWhitespace) - first + 1);
}

bool is_visible(char c) { return c > 0x20 && c < 0x7f; }

}  // namespace

bool is_token(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return is_visible(c) &&
           std::string_view("\"(),/:;<=>?@[\\]{}").find(c) == std::string_view::npos;
  });
}

bool is_field_value(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return c == '\t' || (byte >= 0x20 && byte != 0x7f);
  });
}

HeadReader::State HeadReader::take(std::string_view& bytes) {
  has_begun_ |= !bytes.empty();
  while (!bytes.empty()) {
    const auto end = bytes.find('\n');
    const bool is_whole = end != std::string_view::npos;
    line_.append(bytes.substr(0, is_whole ? end + 1 : end));
    bytes.remove_prefix(is_whole ? end + 1 : bytes.size());
    if (const State state = check_room(); state != State::kReading) return state;
    if (!is_whole) break;
    if (!line_.ends_with("\r\n")) return refuse("A line ends with LF alone, expected CR LF.");
    const State state = take_line(std::string_view(line_).substr(0, line_.size() - 2));
    line_.clear();
    if (state != State::kReading) return state;
  }
  return State::kReading;
}

HeadReader::State HeadReader::check_room() {
  if (head_.text.empty()) {
    if (line_.size() <= limits_.request_line_bytes) return State::kReading;
    return refuse(414, "uri_too_long", "The request target is too long.");
  }
  if (line_.size() > limits_.header_line_bytes) {
    return refuse(
        431, "headers_too_large",
        "A header line has more than " + std::to_string(limits_.header_line_bytes) + " bytes.");
  }
  if (header_lines_ > limits_.header_lines) {
    return refuse(431, "headers_too_large",
                  "More than " + std::to_string(limits_.header_lines) + " header lines.");
  }
  if (header_bytes_ + line_.size() > limits_.header_bytes) {
    return refuse(431, "headers_too_large",
                  "The header lines have more than " + std::to_string(limits_.header_bytes) +
                      " bytes together.");
  }
  return State::kReading;
}

HeadReader::State HeadReader::take_line(std::string_view line) {
  if (head_.text.empty()) {
    // An empty line may come before a request (RFC 9112, 2.2).
    if (line.empty() && !std::exchange(has_skipped_line_, true)) return State::kReading;
    return take_request_line(line);
  }
  if (line.empty()) return end();
  ++header_lines_;
  header_bytes_ += line.size() + 2;
  if (const State state = check_room(); state != State::kReading) return state;
  return take_header(line);
}

HeadReader::State HeadReader::take_request_line(std::string_view line) {
  const auto first = line.find(' ');
  const auto last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) {
    return refuse("The request line is not METHOD TARGET HTTP/1.1.");
  }
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  is_http_1_1_ = version == "HTTP/1.1";
  const bool is_version = is_http_1_1_ || version == "HTTP/1.0";
  const bool is_target = !target.empty() && std::ranges::all_of(target, is_visible);
  if (!is_token(method) || !is_target || !is_version) {
    return refuse("The request line is not METHOD TARGET HTTP/1.1.");
  }
  head_.method = method;
  head_.text.append(line).append("\r\n");
  return State::kReading;
}

HeadReader::State HeadReader::take_header(std::string_view line) {
  if (kWhitespace.find(line.front()) != std::string_view::npos) {
    return refuse("A header line begins with a space: folded headers are not read.");
  }
  const auto colon = line.find(':');
  if (colon == std::string_view::npos) return refuse("A header line has no colon.");
  const std::string_view name = line.substr(0, colon);
  const std::string_view value = stripped(line.substr(colon + 1));
  if (!is_token(name))
    return refuse("The name of a header has a space or another wrong character.");
  if (!is_field_value(value)) return refuse("The value of a header has a control character.");
  if (equals_ignoring_case(name, "Expect")) {
    if (!equals_ignoring_case(value, "100-continue")) {
      return refuse(417, "expectation_failed", "Expect is 100-continue or absent.");
    }
    head_.expects_continue = is_http_1_1_;
    return State::kReading;
  }
  // The library drops a header without a value, and the change would have no condition.
  if (value.empty() && equals_ignoring_case(name, "If-Match")) {
    return refuse("If-Match is empty, expected an ETag in double quotes, or *.");
  }
  hosts_ += equals_ignoring_case(name, "Host") ? 1U : 0U;
  if (const State state = take_framing(name, value); state != State::kReading) return state;
  head_.text.append(name).append(": ").append(value).append("\r\n");
  return State::kReading;
}

HeadReader::State HeadReader::take_framing(std::string_view name, std::string_view value) {
  if (equals_ignoring_case(name, "Content-Length")) {
    if (std::exchange(has_length_, true)) return refuse("Content-Length is there twice.");
    std::uint64_t length = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), length);
    if (error != std::errc{} || end != value.data() + value.size()) {
      return refuse("Content-Length is not a number.");
    }
    head_.framing = {Framing::Kind::kLength, length};
  } else if (equals_ignoring_case(name, "Transfer-Encoding")) {
    if (std::exchange(has_encoding_, true)) return refuse("Transfer-Encoding is there twice.");
    if (!equals_ignoring_case(value, "chunked")) {
      return refuse("Transfer-Encoding is chunked or absent.");
    }
    if (!is_http_1_1_) return refuse("HTTP/1.0 has no Transfer-Encoding.");
    head_.framing = {Framing::Kind::kChunked, 0};
  }
  return State::kReading;
}

HeadReader::State HeadReader::end() {
  if (has_length_ && has_encoding_) {
    return refuse(
        "Content-Length and Transfer-Encoding are both there: the end of the body is in doubt.");
  }
  if (hosts_ > 1 || (hosts_ == 0 && is_http_1_1_)) {
    return refuse("A request has one Host header, this one has " + std::to_string(hosts_) + ".");
  }
  const bool takes_no_body = head_.method == "GET" || head_.method == "HEAD";
  if (takes_no_body && head_.framing.has_body()) {
    return refuse("A " + head_.method + " request has no body.");
  }
  head_.text.append("\r\n");
  return State::kDone;
}

HeadReader::State HeadReader::refuse(int status, std::string code, std::string detail) {
  refusal_ = {status, std::move(code), std::move(detail)};
  return State::kRefused;
}

}  // namespace cornerfix::server
