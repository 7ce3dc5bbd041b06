/// \file  The inspector's files, with what browsers need to cache them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "server/http_message.hpp"
#include "server/router.hpp"

namespace cornerfix::server {

/// Serves files of a few directories, each mounted at a prefix. Immutable; any threads may call.
class StaticFiles {
 public:
  /// `root` is served at `prefix` ("" is the site's root; otherwise segments without slashes at
  /// the ends, like "vendor/leaflet").
  void mount(std::string_view prefix, std::filesystem::path root);

  /// Nothing when no such file is served. Never leaves the mounted directories.
  [[nodiscard]] std::optional<Response> get(const PathSegments& path,
                                            std::string_view if_none_match) const;

  [[nodiscard]] bool exists(const PathSegments& path) const { return find(path).has_value(); }

 private:
  struct Mount {
    PathSegments prefix;
    std::filesystem::path root;
  };

  [[nodiscard]] std::optional<std::filesystem::path> find(const PathSegments& path) const;

  std::vector<Mount> mounts_;
};

}  // namespace cornerfix::server
