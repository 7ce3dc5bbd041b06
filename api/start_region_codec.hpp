/// \file  `near` of a session: where the robot may be at its first scan.
#pragma once

#include <optional>

#include <cornerfix/localizer_params.hpp>

#include "api/json_codec.hpp"
#include "api/json_field.hpp"

namespace cornerfix::api {

/// Nothing when it is wrong; the field's errors then have the reason.
[[nodiscard]] std::optional<StartRegion> read_start_region(const JsonField& field);

/// As it was read, with the tolerance that is in force; null for none.
[[nodiscard]] Json render_start_region(const std::optional<StartRegion>& region);

}  // namespace cornerfix::api
