/// \file  All of a database copied into an empty one, of the same engine or of the other.
#pragma once

#include <cstddef>
#include <memory>

#include <cornerfix/result.hpp>

#include "storage/database.hpp"

namespace cornerfix::storage {

struct CopiedRows {
  std::size_t maps = 0;
  std::size_t sessions = 0;
  std::size_t tokens = 0;
};

/// Copies every map, session and token of `from` with its identifiers, each map and session in a
/// transaction of its own. Each is read back and must have the SHA-256 of its source.
///
/// Jobs are not copied. kConflict when `from` has jobs that are not finished, when `to` is not
/// empty or when `from` changes meanwhile. kCorruptData when a copy differs from its source. What
/// was copied before an error stays: such a target is to be deleted.
[[nodiscard]] Result<CopiedRows> copy_database(const std::shared_ptr<Database>& from,
                                               const std::shared_ptr<Database>& to);

}  // namespace cornerfix::storage
