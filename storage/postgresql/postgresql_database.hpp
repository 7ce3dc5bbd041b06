/// \file  The door to PostgreSQL: a program may be built without it.
#pragma once

#include <memory>
#include <string>

#include "storage/database.hpp"

namespace cornerfix::storage {

/// As Database::open(), for a URL of libpq. A schema without tables becomes a new database.
/// kUnavailable when the server cannot be reached, kInvalidArgument for a wrong URL, tables of
/// another program, or a program that was built without PostgreSQL.
[[nodiscard]] Result<std::shared_ptr<Database>> open_postgresql(const std::string& url,
                                                                Synchronous synchronous,
                                                                int busy_timeout_ms);

}  // namespace cornerfix::storage
