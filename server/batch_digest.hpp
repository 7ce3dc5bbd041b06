/// \file  A number for the content of a batch of scans.
#pragma once

#include <cstdint>
#include <span>

#include <cornerfix/localizer.hpp>

namespace cornerfix::server {

/// The same for the same scans, in any format that they were sent in; never 0. To notice that a
/// sequence is used for two batches, not to keep an attacker from it.
[[nodiscard]] std::uint64_t digest_of(std::span<const RobotScan> scans);

}  // namespace cornerfix::server
