/// \file  Numbers that no scan of a log can have, in any format.
#pragma once

#include <optional>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// The first that is beyond what the server takes, or nothing. `field` of the error is "stamp",
/// "odom" or "pose".
[[nodiscard]] std::optional<Error> find_value_beyond_limits(const LogScan& scan);

}  // namespace cornerfix::evaluation
