/// \file  Revisions of maps as JSON documents.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "api/json_codec.hpp"

namespace cornerfix::api {

struct RevisionEntry {
  std::uint64_t revision = 0;
  std::string_view digest;
  std::string_view created;  ///< RFC 3339.
  std::string_view origin;   ///< "scans"; empty: not known.
  std::size_t features = 0;
  std::uint64_t archive_bytes = 0;  ///< 0 for the present revision.
  bool is_current = false;
};
[[nodiscard]] Json render_revisions(std::string_view map, std::span<const RevisionEntry> revisions);

/// The version of a map that a session's last pose is in.
struct MapVersionEntry {
  std::string_view map;
  std::uint64_t revision = 0;
  std::string_view digest;  ///< Empty: not known.
  bool is_current = false;  ///< It is the map's present revision.
};
[[nodiscard]] Json render_map_version(const MapVersionEntry& version);

}  // namespace cornerfix::api
