/// \file  The API's own description, openapi.yaml, as the JSON that is served.
#pragma once

#include <string_view>

namespace cornerfix::api {

/// Converted from openapi.yaml when the program was built.
[[nodiscard]] std::string_view openapi_json();

}  // namespace cornerfix::api
