/// \file  The tables of maps, sessions, tokens and jobs in SQLite.
#pragma once

#include <memory>

#include "storage/job_tables.hpp"
#include "storage/map_tables.hpp"
#include "storage/session_tables.hpp"
#include "storage/token_tables.hpp"

namespace cornerfix::storage {

class SqliteDatabase;

/// Each belongs to the database and must not outlive it.
[[nodiscard]] std::unique_ptr<MapTables> make_map_tables(SqliteDatabase& database);
[[nodiscard]] std::unique_ptr<SessionTables> make_session_tables(SqliteDatabase& database);
[[nodiscard]] std::unique_ptr<TokenTables> make_token_tables(SqliteDatabase& database);
[[nodiscard]] std::unique_ptr<JobTables> make_job_tables(SqliteDatabase& database);

}  // namespace cornerfix::storage
