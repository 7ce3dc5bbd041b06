/// \file  An online copy of a database file.
#pragma once

#include <filesystem>

#include <cornerfix/result.hpp>

namespace cornerfix::storage {

/// Copies the database at `source`, which a server may have open, to `target`, which must not
/// exist. The copy holds one moment's state and is checked before it gets its name; after an error
/// there is none.
[[nodiscard]] Result<void> back_up(const std::filesystem::path& source,
                                   const std::filesystem::path& target);

}  // namespace cornerfix::storage
