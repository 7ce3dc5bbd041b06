#include "server/used_versions.hpp"

#include <nlohmann/json.hpp>

#include "api/revision_codec.hpp"

namespace cornerfix::server {

api::Json UsedVersions::of(const api::Json& answer) {
  if (answer.is_null() || answer["pose"].is_null()) return nullptr;
  const auto map = answer["pose"]["map"].get<std::string>();
  const auto revision = answer["pose"]["revision"].get<std::uint64_t>();
  const auto [entry, is_new] = known_.try_emplace({map, revision});
  if (is_new) {
    if (auto found = maps_.version(map, revision)) entry->second = std::move(*found);
  }
  const MapVersion& version = entry->second;
  return api::render_map_version({.map = map,
                                  .revision = revision,
                                  .digest = version.digest,
                                  .is_current = version.is_current});
}

}  // namespace cornerfix::server
