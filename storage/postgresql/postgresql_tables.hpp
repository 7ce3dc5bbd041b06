/// \file  The tables of maps, sessions and tokens in PostgreSQL.
#pragma once

#include <memory>

#include "storage/map_tables.hpp"
#include "storage/session_tables.hpp"
#include "storage/token_tables.hpp"

namespace cornerfix::storage {

class PostgresqlConnection;

/// Each works on the connection and must not outlive it.
[[nodiscard]] std::unique_ptr<MapTables> make_map_tables(PostgresqlConnection& connection);
[[nodiscard]] std::unique_ptr<SessionTables> make_session_tables(PostgresqlConnection& connection);
[[nodiscard]] std::unique_ptr<TokenTables> make_token_tables(PostgresqlConnection& connection);

}  // namespace cornerfix::storage
