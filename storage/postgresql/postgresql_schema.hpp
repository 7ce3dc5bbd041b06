/// \file  The tables in PostgreSQL, as numbered migrations: migration i takes schema i to i + 1.
#pragma once

#include <cstdint>
#include <span>

#include <cornerfix/result.hpp>

namespace cornerfix::storage {

class PostgresqlConnection;

/// All migrations in order, each SQL statements. A released one is never edited.
[[nodiscard]] std::span<const char* const> postgresql_migrations();

/// The version that this program reads and writes.
[[nodiscard]] std::int64_t postgresql_schema_version();

/// The version in the database; 0 where there is no table of versions. Throws StorageError.
[[nodiscard]] std::int64_t stored_schema_version(PostgresqlConnection& connection);

/// Applies what the database lacks of `steps`, in one transaction. Servers that start together
/// wait for each other. kInvalidArgument, and nothing changed, for a newer schema or for a schema
/// that has tables of another program. Throws StorageError.
[[nodiscard]] Result<void> migrate(PostgresqlConnection& connection,
                                   std::span<const char* const> steps);

}  // namespace cornerfix::storage
