/// \file  Documents and errors as responses in the format that the client asked for.
#pragma once

#include <string_view>

#include <cornerfix/result.hpp>

#include "api/json_codec.hpp"
#include "server/http_message.hpp"
#include "server/localization_service.hpp"

namespace cornerfix::server {

[[nodiscard]] Response document_response(const Request& request, int status,
                                         const api::Json& document);
/// `json` is a document's text, sent as it is unless another format was asked for.
[[nodiscard]] Response text_response(const Request& request, int status, const std::string& json);
/// Of a map's archive.
inline constexpr const char* kArchiveType = "application/vnd.sqlite3";

/// The problem for `error`. What the caller may not know goes to the log, by the request's id.
[[nodiscard]] Response error_response(const Request& request, const Error& error);

/// The session's last answer as a Server-Sent Event, if there is one.
[[nodiscard]] std::optional<std::string> last_answer_event(const SessionView& view);

}  // namespace cornerfix::server
