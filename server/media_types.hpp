/// \file  Content-Type and Accept, as far as this service has something to choose from.
#pragma once

#include <optional>
#include <string_view>

#include "api/requests.hpp"

namespace cornerfix::server {

/// The format of a body with this Content-Type, or nothing when it is none of ours. Without any
/// Content-Type a body is taken as JSON.
[[nodiscard]] std::optional<api::BodyFormat> format_of_content_type(std::string_view content_type);

/// The format that an Accept header likes best; JSON when it does not care or likes none of ours.
[[nodiscard]] api::BodyFormat best_format(std::string_view accept);

}  // namespace cornerfix::server
