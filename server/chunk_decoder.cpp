#include "server/chunk_decoder.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

namespace cornerfix::server {
namespace {

constexpr std::size_t kMaxSizeLine = 256;  // A number and its extensions.
constexpr std::size_t kMaxSizeDigits = 8;  // A chunk of 4 GiB is larger than any limit.

}  // namespace

ChunkDecoder::State ChunkDecoder::take(std::string_view& bytes, std::string& body) {
  while (!bytes.empty()) {
    if (part_ == Part::kData) {
      take_data(bytes, body);
      continue;
    }
    const auto end = bytes.find('\n');
    const bool is_whole = end != std::string_view::npos;
    line_.append(bytes.substr(0, is_whole ? end + 1 : end));
    bytes.remove_prefix(is_whole ? end + 1 : bytes.size());
    const bool is_trailer = part_ == Part::kTrailers;
    if (is_trailer && trailer_bytes_ + line_.size() > limits_.header_bytes) {
      return refuse(431, "headers_too_large", "The trailers are too large.");
    }
    if (!is_trailer && line_.size() > kMaxSizeLine) {
      return refuse(400, "malformed", "The size of a chunk is too long.");
    }
    if (!is_whole) break;
    if (!line_.ends_with("\r\n")) {
      return refuse(400, "malformed", "A line between chunks ends with LF alone, expected CR LF.");
    }
    const State state = take_line(std::string_view(line_).substr(0, line_.size() - 2));
    line_.clear();
    if (state != State::kReading) return state;
  }
  return State::kReading;
}

void ChunkDecoder::take_data(std::string_view& bytes, std::string& body) {
  const auto taken = static_cast<std::size_t>(std::min<std::uint64_t>(data_left_, bytes.size()));
  body.append(bytes.substr(0, taken));
  bytes.remove_prefix(taken);
  data_left_ -= taken;
  if (data_left_ == 0) part_ = Part::kDataEnd;
}

ChunkDecoder::State ChunkDecoder::take_line(std::string_view line) {
  if (part_ == Part::kTrailers) return take_trailer(line);
  if (part_ == Part::kSize) return take_size(line);
  if (!line.empty()) return refuse(400, "malformed", "A chunk has more data than its size.");
  part_ = Part::kSize;
  return State::kReading;
}

ChunkDecoder::State ChunkDecoder::take_size(std::string_view line) {
  const std::string_view digits = line.substr(0, line.find_first_of("; \t"));
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), data_left_, 16);
  const bool is_size = error == std::errc{} && end == digits.data() + digits.size() &&
                       digits.size() <= kMaxSizeDigits;
  if (!is_size || !is_field_value(line)) {
    return refuse(400, "malformed", "The size of a chunk is not a hexadecimal number.");
  }
  part_ = data_left_ > 0 ? Part::kData : Part::kTrailers;
  return State::kReading;
}

ChunkDecoder::State ChunkDecoder::take_trailer(std::string_view line) {
  if (line.empty()) return State::kDone;
  trailer_bytes_ += line.size() + 2;
  if (++trailers_ > limits_.header_lines) {
    return refuse(431, "headers_too_large",
                  "More than " + std::to_string(limits_.header_lines) + " trailers.");
  }
  const auto colon = line.find(':');
  if (colon == std::string_view::npos || !is_token(line.substr(0, colon)) ||
      !is_field_value(line)) {
    return refuse(400, "malformed", "A trailer is not NAME: VALUE.");
  }
  return State::kReading;
}

ChunkDecoder::State ChunkDecoder::refuse(int status, std::string code, std::string detail) {
  refusal_ = {status, std::move(code), std::move(detail)};
  return State::kRefused;
}

}  // namespace cornerfix::server
