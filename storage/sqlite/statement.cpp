#include "storage/sqlite/statement.hpp"

#include <algorithm>
#include <limits>

namespace cornerfix::storage {

BlobView Statement::blob(int column) const {
  const SQLite::Column value = statement_.getColumn(column);
  return {static_cast<const std::uint8_t*>(value.getBlob()),
          static_cast<std::size_t>(value.getBytes())};
}

void Statement::set(int index, BlobView value) {
  // SQLite refuses what is near this limit by itself; the interface cannot even express more.
  const std::size_t limit = std::numeric_limits<int>::max();
  statement_.bindNoCopy(index, value.data(), static_cast<int>(std::min(value.size(), limit)));
}

}  // namespace cornerfix::storage
