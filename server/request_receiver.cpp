#include "server/request_receiver.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace cornerfix::server {
namespace {

void append_chunk(std::string& text, std::string_view data) {
  std::array<char, 16> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), data.size(), 16).ptr;
  text.append(digits.data(), end).append("\r\n").append(data).append("\r\n");
}

}  // namespace

RequestReceiver::State RequestReceiver::take(std::string_view& bytes) {
  if (state_ == State::kHead) take_head(bytes);
  if (state_ != State::kBody) return state_;
  if (chunks_) {
    take_chunks(bytes);
  } else {
    take_length(bytes);
  }
  return state_;
}

void RequestReceiver::take_head(std::string_view& bytes) {
  const HeadReader::State state = head_reader_.take(bytes);
  if (state == HeadReader::State::kRefused) refuse(head_reader_.refusal());
  if (state != HeadReader::State::kDone) return;
  RequestHead& head = head_reader_.head();
  text_ = std::move(head.text);
  length_left_ = head.framing.length;
  if (head.framing.kind == Framing::Kind::kChunked) chunks_.emplace(limits_);
  state_ = head.framing.has_body() ? State::kBody : State::kComplete;
}

void RequestReceiver::take_length(std::string_view& bytes) {
  const auto taken = static_cast<std::size_t>(std::min<std::uint64_t>(length_left_, bytes.size()));
  text_.append(bytes.substr(0, taken));
  bytes.remove_prefix(taken);
  length_left_ -= taken;
  if (length_left_ == 0) state_ = State::kComplete;
}

void RequestReceiver::take_chunks(std::string_view& bytes) {
  std::string data;
  const ChunkDecoder::State state = chunks_->take(bytes, data);
  if (!data.empty()) append_chunk(text_, data);
  if (state == ChunkDecoder::State::kRefused) refuse(chunks_->refusal());
  if (state != ChunkDecoder::State::kDone) return;
  text_.append("0\r\n\r\n");
  state_ = State::kComplete;
}

void RequestReceiver::refuse(const Refusal& refusal) {
  refusal_ = refusal;
  state_ = State::kRefused;
}

}  // namespace cornerfix::server
