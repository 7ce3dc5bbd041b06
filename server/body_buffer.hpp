/// \file  Request bodies taken in pieces, inflated when they are gzip, never beyond a limit.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace cornerfix::server {

/// Gathers a body. A bomb costs no more than the limit: inflating stops there.
/// One request's, not synchronised.
class BodyBuffer {
 public:
  enum class State { kGood, kTooLarge, kBadGzip };

  /// \param wire_bytes  Of the pieces together, or 0 where that is not known.
  BodyBuffer(bool gzip, std::size_t max_bytes, std::size_t wire_bytes = 0);
  ~BodyBuffer();
  BodyBuffer(const BodyBuffer&) = delete;
  BodyBuffer& operator=(const BodyBuffer&) = delete;

  /// Takes the next piece as it came over the wire. Once not good, further pieces are dropped.
  State append(std::string_view piece);

  /// To be called after the last piece: a gzip stream that ends early is bad.
  State finish();

  /// The body, when finish() said kGood.
  [[nodiscard]] std::string take();

 private:
  struct Inflater;

  State inflate(std::string_view piece);

  const std::size_t max_bytes_;
  State state_ = State::kGood;
  std::string body_;
  std::unique_ptr<Inflater> inflater_;  ///< Null for an identity body.
};

}  // namespace cornerfix::server
