/// \file  The tables, as numbered migrations: migration i takes a file from schema i to i + 1.
#pragma once

#include <cstdint>
#include <span>

#include <cornerfix/result.hpp>

namespace SQLite {  // NOLINT(readability-identifier-naming): the library's own name.
class Database;
}

namespace cornerfix::storage {

/// PRAGMA application_id of our files: "CFIX".
inline constexpr std::int64_t kApplicationId = 0x43464958;

/// All migrations in order, each SQL statements. A landed one is never edited; a change of the
/// schema is a new one at the end.
[[nodiscard]] std::span<const char* const> migrations();

/// PRAGMA user_version of files that this program reads and writes.
[[nodiscard]] std::int64_t schema_version();

/// Applies what `connection` lacks of `steps`, in one transaction that holds every other writer
/// off. A file of a newer schema is refused (kInvalidArgument) and unchanged. Throws what SQLiteCpp
/// throws; the file is then unchanged.
[[nodiscard]] Result<void> migrate(SQLite::Database& connection,
                                   std::span<const char* const> steps);

/// kInvalidArgument when `found`, a file's user_version, is above `known`.
[[nodiscard]] Result<void> check_schema_version(std::int64_t found, std::int64_t known);

/// PRAGMA user_version. Throws what SQLiteCpp throws.
[[nodiscard]] std::int64_t user_version(SQLite::Database& connection);

}  // namespace cornerfix::storage
