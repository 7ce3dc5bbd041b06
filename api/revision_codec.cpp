#include "api/revision_codec.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace cornerfix::api {
namespace {

Json known_text(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }

}  // namespace

Json render_revisions(std::string_view map, std::span<const RevisionEntry> revisions) {
  Json list = Json::array();
  for (const RevisionEntry& revision : revisions) {
    list.push_back({{"revision", revision.revision},
                    {"digest", revision.digest},
                    {"created", revision.created},
                    {"origin", known_text(revision.origin)},
                    {"features", revision.features},
                    {"archive_bytes", revision.archive_bytes},
                    {"current", revision.is_current}});
  }
  return {{"map", map}, {"revisions", std::move(list)}};
}

Json render_map_version(const MapVersionEntry& version) {
  return {{"map", version.map},
          {"revision", version.revision},
          {"digest", known_text(version.digest)},
          {"current", version.is_current}};
}

}  // namespace cornerfix::api
