/// \file  Which version of a map a session's last pose is in, for the sessions of one response.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>

#include "api/json_codec.hpp"
#include "server/map_library.hpp"

namespace cornerfix::server {

/// Looks each version up once, however many sessions use it.
class UsedVersions {
 public:
  explicit UsedVersions(MapLibrary& maps) : maps_(maps) {}

  /// Null for a null answer and for one without a pose. The digest is null when it is not known.
  [[nodiscard]] api::Json of(const api::Json& answer);

 private:
  MapLibrary& maps_;
  std::map<std::pair<std::string, std::uint64_t>, MapVersion> known_;
};

}  // namespace cornerfix::server
