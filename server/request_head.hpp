/// \file  The head of a request as it comes off the wire, read strictly (RFC 9112).
///
/// A proxy in front of the server and the server itself must agree where each request ends.
/// Everything that two readers could understand differently is refused, and the HTTP library is
/// handed a head that is written anew from what was understood.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace cornerfix::server {

/// How the body of a request is delimited (RFC 9112, 6).
struct Framing {
  enum class Kind { kNone, kLength, kChunked };
  Kind kind = Kind::kNone;
  std::uint64_t length = 0;  ///< Of kLength.

  [[nodiscard]] bool has_body() const {
    return kind == Kind::kChunked || (kind == Kind::kLength && length > 0);
  }
};

/// A request that is not read further. The connection closes after the answer, because what
/// follows cannot be trusted.
struct Refusal {
  int status = 400;
  std::string code = "malformed";
  std::string detail{};
};

struct HeadLimits {
  std::size_t request_line_bytes = 8192;
  std::size_t header_line_bytes = 8192;
  std::size_t header_lines = 100;
  std::size_t header_bytes = std::size_t{32} << 10U;  ///< Of all header lines together.
};

struct RequestHead {
  std::string method;
  std::string text;  ///< For the HTTP library: the head without Expect, with its empty line.
  Framing framing{};
  bool expects_continue = false;  ///< The client waits for "100 Continue" before it sends the body.
};

/// Takes bytes in pieces of any size and never keeps more than the limits allow.
class HeadReader {
 public:
  enum class State { kReading, kDone, kRefused };

  explicit HeadReader(HeadLimits limits = {}) : limits_(limits) {}

  /// Removes from `bytes` what belongs to the head.
  State take(std::string_view& bytes);

  /// Whether a byte of the request has arrived.
  [[nodiscard]] bool has_begun() const { return has_begun_; }
  /// Bytes that it keeps.
  [[nodiscard]] std::size_t size() const { return line_.size() + head_.text.size(); }
  /// After kDone.
  [[nodiscard]] RequestHead& head() { return head_; }
  /// After kRefused.
  [[nodiscard]] const Refusal& refusal() const { return refusal_; }

 private:
  State take_line(std::string_view line);
  State take_request_line(std::string_view line);
  State take_header(std::string_view line);
  State take_framing(std::string_view name, std::string_view value);
  State end();
  State check_room();
  State refuse(int status, std::string code, std::string detail);
  State refuse(std::string detail) { return refuse(400, "malformed", std::move(detail)); }

  HeadLimits limits_;
  std::string line_;  ///< Received of the current line.
  RequestHead head_;
  Refusal refusal_;
  bool has_begun_ = false;
  bool has_skipped_line_ = false;
  bool is_http_1_1_ = false;
  bool has_length_ = false;
  bool has_encoding_ = false;
  std::size_t hosts_ = 0;
  std::size_t header_lines_ = 0;
  std::size_t header_bytes_ = 0;
};

/// Whether `text` is a token, such as a method or the name of a header (RFC 9110, 5.6.2).
[[nodiscard]] bool is_token(std::string_view text);

/// Whether `text` may be the value of a header: no control characters except tabs.
[[nodiscard]] bool is_field_value(std::string_view text);

}  // namespace cornerfix::server
