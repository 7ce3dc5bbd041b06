#include "storage/known_map.hpp"

#include <string>
#include <utility>

#include "storage/map_store.hpp"

namespace cornerfix::storage {
namespace {

std::string revision_text(std::uint64_t revision) {
  return revision == 0 ? std::string("no map") : "revision " + std::to_string(revision);
}

Error other_map(std::string message) {
  return {ErrorCode::kConflict, std::move(message), "revision"};
}

}  // namespace

Result<void> check_known(const MapInfo& map, const KnownMap& known) {
  const bool is_another = map.revision > 0 && known.id != 0 && map.id != known.id;
  if (is_another) return other_map("the map was deleted, and another one has its name");
  if (map.revision != known.revision) {
    return other_map("the map was changed: there is " + revision_text(map.revision) +
                     ", expected " + revision_text(known.revision));
  }
  if (known.description && map.description != *known.description)
    return other_map("the map was changed: it has another description");
  return {};
}

}  // namespace cornerfix::storage
