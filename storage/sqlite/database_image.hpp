/// \file  SQLite files as bytes in memory: made, and opened without trusting them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/result.hpp>

namespace SQLite {  // NOLINT(readability-identifier-naming): the library's own name.
class Database;
}

namespace cornerfix::storage {

/// What says that a file is of one kind.
struct ImageKind {
  std::int64_t application_id = 0;
  std::int64_t version = 0;  ///< PRAGMA user_version.
  const char* schema = "";   ///< Statements that create its tables.
};

/// An empty database in memory of that kind. Throws what SQLiteCpp throws.
[[nodiscard]] std::unique_ptr<SQLite::Database> make_image(const ImageKind& kind);

/// The bytes of a database's file. Throws what SQLiteCpp throws.
[[nodiscard]] std::vector<std::uint8_t> bytes_of(SQLite::Database& database);

/// Opens the bytes of a file that anyone may have made, read-only and in memory. No code of its own
/// is run: triggers, views and functions in its schema are off. The schema must be letter for
/// letter that of `kind` before any table is read. Then all pages are checked.
///
/// kMalformed for what is not SQLite's or is damaged, kInvalidArgument for another kind, version or
/// schema.
[[nodiscard]] Result<std::unique_ptr<SQLite::Database>> open_untrusted_image(
    std::span<const std::uint8_t> bytes, const ImageKind& kind);

}  // namespace cornerfix::storage
