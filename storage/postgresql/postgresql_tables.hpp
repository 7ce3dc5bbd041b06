/// \file  The tables of maps, sessions, tokens and jobs in PostgreSQL.
#pragma once

#include <memory>

#include "storage/job_tables.hpp"
#include "storage/map_tables.hpp"
#include "storage/session_tables.hpp"
#include "storage/token_tables.hpp"

namespace cornerfix::storage {

class PostgresqlConnection;

/// Each works on the connection and must not outlive it.
[[nodiscard]] std::unique_ptr<MapTables> make_map_tables(PostgresqlConnection& connection);
[[nodiscard]] std::unique_ptr<SessionTables> make_session_tables(PostgresqlConnection& connection);
[[nodiscard]] std::unique_ptr<TokenTables> make_token_tables(PostgresqlConnection& connection);
[[nodiscard]] std::unique_ptr<JobTables> make_job_tables(PostgresqlConnection& connection);

}  // namespace cornerfix::storage
