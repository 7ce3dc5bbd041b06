/// \file  Identifiers that nobody guesses.
#pragma once

#include <string>

namespace cornerfix::server {

/// 128 random bits in hexadecimal digits. Any threads may call.
[[nodiscard]] std::string random_id();

}  // namespace cornerfix::server
