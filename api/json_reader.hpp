/// \file  JSON text to parse events, at the speed that scans need.
#pragma once

#include <string_view>

#include "api/document_builder.hpp"

namespace cornerfix::api {

/// Feeds `text` to `builder`. False: it is not JSON, or the builder stopped; see builder.problem().
/// Every value is checked, those that the builder ignores too. simdjson on demand is used here
/// only.
[[nodiscard]] bool read_json(std::string_view text, DocumentBuilder& builder);

}  // namespace cornerfix::api
