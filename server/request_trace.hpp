/// \file  The names under which a request is followed through several programs.
#pragma once

#include <string>
#include <string_view>

namespace cornerfix::server {

/// Whether a client's X-Request-Id is taken over: 1 to 128 letters, digits, '.', '_' or '-'.
[[nodiscard]] bool is_request_id(std::string_view text);

/// Whether `text` is a traceparent of version 00 (W3C Trace Context) with ids that are not zero.
[[nodiscard]] bool is_traceparent(std::string_view text);

/// The trace id in a traceparent; empty for no such text.
[[nodiscard]] std::string_view trace_id_of(std::string_view traceparent);

}  // namespace cornerfix::server
