/// \file  A chunked request body, read strictly (RFC 9112, 7.1).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/request_head.hpp"

namespace cornerfix::server {

/// Takes bytes in pieces of any size. Chunk extensions and trailers are bounded and dropped.
class ChunkDecoder {
 public:
  enum class State { kReading, kDone, kRefused };

  explicit ChunkDecoder(HeadLimits limits = {}) : limits_(limits) {}

  /// Removes from `bytes` what belongs to the body, and appends its data to `body`.
  State take(std::string_view& bytes, std::string& body);

  /// After kRefused.
  [[nodiscard]] const Refusal& refusal() const { return refusal_; }

 private:
  enum class Part { kSize, kData, kDataEnd, kTrailers };

  void take_data(std::string_view& bytes, std::string& body);
  State take_line(std::string_view line);
  State take_size(std::string_view line);
  State take_trailer(std::string_view line);
  State refuse(int status, std::string code, std::string detail);

  HeadLimits limits_;
  Part part_ = Part::kSize;
  std::uint64_t data_left_ = 0;  ///< Of the current chunk.
  std::string line_;             ///< Received of the current line.
  std::size_t trailers_ = 0;
  std::size_t trailer_bytes_ = 0;
  Refusal refusal_;
};

}  // namespace cornerfix::server
