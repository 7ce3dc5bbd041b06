#include "server/body_buffer.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <new>
#include <utility>

namespace cornerfix::server {

/// A zlib stream over one or more gzip members, as RFC 1952 allows.
struct BodyBuffer::Inflater {
  z_stream stream{};
  bool at_member_end = false;

  Inflater() {
    constexpr int kGzipOnly = 16 + MAX_WBITS;
    if (inflateInit2(&stream, kGzipOnly) != Z_OK) throw std::bad_alloc();
  }
  ~Inflater() { inflateEnd(&stream); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
};

BodyBuffer::BodyBuffer(bool gzip, std::size_t max_bytes, std::size_t wire_bytes)
    : max_bytes_(max_bytes) {
  if (gzip) {
    inflater_ = std::make_unique<Inflater>();
  } else {
    body_.reserve(std::min(wire_bytes, max_bytes));
  }
}

BodyBuffer::~BodyBuffer() = default;

BodyBuffer::State BodyBuffer::append(std::string_view piece) {
  if (state_ != State::kGood) return state_;
  if (inflater_) return state_ = inflate(piece);
  if (piece.size() > max_bytes_ - body_.size()) return state_ = State::kTooLarge;
  body_.append(piece);
  return state_;
}

BodyBuffer::State BodyBuffer::inflate(std::string_view piece) {
  z_stream& stream = inflater_->stream;
  // zlib does not write to its input; its field is not const for historical reasons.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(piece.data()));
  stream.avail_in = static_cast<uInt>(piece.size());
  std::array<char, 16384> out;
  do {
    if (inflater_->at_member_end) {
      if (stream.avail_in == 0) break;
      inflateReset(&stream);
    }
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    const int code = ::inflate(&stream, Z_NO_FLUSH);
    if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR) return State::kBadGzip;
    inflater_->at_member_end = code == Z_STREAM_END;
    const std::size_t made = out.size() - stream.avail_out;
    if (made > max_bytes_ - body_.size()) return State::kTooLarge;
    body_.append(out.data(), made);
  } while (stream.avail_in > 0 || stream.avail_out == 0);
  return State::kGood;
}

BodyBuffer::State BodyBuffer::finish() {
  if (state_ == State::kGood && inflater_ && !inflater_->at_member_end) state_ = State::kBadGzip;
  return state_;
}

std::string BodyBuffer::take() { return std::move(body_); }

}  // namespace cornerfix::server
