#include "storage/postgresql/postgresql_database.hpp"

namespace cornerfix::storage {

Result<std::shared_ptr<Database>> open_postgresql(const std::string&, Synchronous, int) {
  return Error{ErrorCode::kInvalidArgument,
               "this program was built without PostgreSQL (CORNERFIX_BUILD_POSTGRESQL)",
               "postgresql://"};
}

}  // namespace cornerfix::storage
