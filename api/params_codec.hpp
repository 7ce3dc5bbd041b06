/// \file  Settings by their names in the code: `options` of a session, `parameters` of a map.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cornerfix/localizer_params.hpp>
#include <cornerfix/mapper.hpp>

#include "api/json_field.hpp"

namespace cornerfix::api {

/// Sets what `object` has and leaves the rest. A name that does not exist and a value outside its
/// limits are errors, with the names that exist.
void read_params(const JsonField& object, LocalizerParams& params);
void read_params(const JsonField& object, MapperParams& params);

[[nodiscard]] nlohmann::ordered_json params_to_json(const LocalizerParams& params);
[[nodiscard]] nlohmann::ordered_json params_to_json(const MapperParams& params);

}  // namespace cornerfix::api
