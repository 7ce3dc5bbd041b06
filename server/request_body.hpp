/// \file  How the body of a request comes off the wire: as it is framed, inflated, in parts or not
/// at all.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "server/http_message.hpp"
#include "server/request_head.hpp"
#include "server/router.hpp"

namespace httplib {
struct Request;
class ContentReader;
}  // namespace httplib

namespace cornerfix::server {

/// Of a run that is to be mapped by a job.
inline constexpr std::size_t kMaxRunBytes = std::size_t{128} << 20U;

/// Of a request whose head was received by RequestReceiver.
[[nodiscard]] Framing framing_of(const httplib::Request& raw);

/// One request on its way to its answer.
struct Exchange {
  httplib::Request& raw;
  const httplib::ContentReader* reader;  ///< Null when the library reads no body for the method.
  Framing framing{};
  Request request{};
  std::string route = "none";  ///< Pattern, for the metrics.
  bool body_was_read = false;
  bool close = false;  ///< What follows on the connection cannot be trusted.
};

/// Reads the body into the exchange's request, by the route's rule and `limit` bytes at most, or
/// answers one that cannot be read. Archives and forms have limits of their own, and their content
/// type is checked, too.
[[nodiscard]] std::optional<Response> take_body(Exchange& exchange, BodyRule rule,
                                                std::size_t limit);

/// Whether a part of the body may still be on its way, so that the connection has to close.
[[nodiscard]] bool is_left_unread(const Exchange& exchange);

}  // namespace cornerfix::server
