/// \file  One request as it arrives: its head, then its body.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/chunk_decoder.hpp"
#include "server/request_head.hpp"

namespace cornerfix::server {

/// Takes bytes in pieces of any size and checks them as they come.
class RequestReceiver {
 public:
  enum class State { kHead, kBody, kComplete, kRefused };

  explicit RequestReceiver(HeadLimits limits = {}) : limits_(limits), head_reader_(limits) {}

  /// Removes from `bytes` what belongs to this request: what is left is the next one's.
  State take(std::string_view& bytes);

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool has_begun() const { return head_reader_.has_begun(); }
  /// From kBody on.
  [[nodiscard]] const RequestHead& head() { return head_reader_.head(); }
  /// After kRefused.
  [[nodiscard]] const Refusal& refusal() const { return refusal_; }

  /// What was received of the request since the last call, as the HTTP library shall read it: a
  /// head that leaves no doubt, and chunks without extensions and trailers.
  [[nodiscard]] std::string take_text() { return std::exchange(text_, {}); }
  /// Bytes that it keeps.
  [[nodiscard]] std::size_t size() const { return head_reader_.size() + text_.size(); }

 private:
  void take_head(std::string_view& bytes);
  void take_length(std::string_view& bytes);
  void take_chunks(std::string_view& bytes);
  void refuse(const Refusal& refusal);

  HeadLimits limits_;
  HeadReader head_reader_;
  std::optional<ChunkDecoder> chunks_;
  State state_ = State::kHead;
  std::uint64_t length_left_ = 0;  ///< Of a body with Content-Length.
  std::string text_;
  Refusal refusal_;
};

}  // namespace cornerfix::server
