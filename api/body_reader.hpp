/// \file  A request's body in any of its formats, as one document.
#pragma once

#include <string_view>
#include <variant>

#include "api/document_builder.hpp"

namespace cornerfix::api {

/// The document of `body`: 400 when it cannot be read, 413 above a limit, 422 when it is no
/// object. A member that is there twice is 400.
[[nodiscard]] std::variant<Document, Problem> read_body(std::string_view body, BodyFormat format,
                                                        const RequestLimits& limits);

}  // namespace cornerfix::api
