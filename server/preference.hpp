/// \file  The header Prefer (RFC 7240).
#pragma once

#include <string_view>

namespace cornerfix::server {

/// Whether one of the preferences in the value of a header is "respond-async". Others are ignored,
/// as the RFC allows.
[[nodiscard]] bool prefers_async(std::string_view header);

}  // namespace cornerfix::server
