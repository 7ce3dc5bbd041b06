/// \file  Whether a client holds what it asks for, or knows what it changes (RFC 9110, 13.1).
#pragma once

#include <string_view>

namespace cornerfix::server {

/// Whether the list of an If-None-Match header names `tag`, by weak comparison, or is `*`. What
/// comes after something that is no entity tag is not read.
[[nodiscard]] bool names_entity_tag(std::string_view if_none_match, std::string_view tag);

/// The same of an If-Match header and a strong `tag`, by strong comparison: a weak tag never
/// matches.
[[nodiscard]] bool requires_entity_tag(std::string_view if_match, std::string_view tag);

}  // namespace cornerfix::server
