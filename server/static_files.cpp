#include "server/static_files.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include "server/entity_tag.hpp"

namespace cornerfix::server {
namespace {

std::string content_type_of(const std::filesystem::path& path) {
  static const std::map<std::string, std::string, std::less<>> types = {
      {".html", "text/html; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".mjs", "text/javascript; charset=utf-8"},
      {".json", "application/json"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".ico", "image/x-icon"},
  };
  const auto found = types.find(path.extension().string());
  return found == types.end() ? "application/octet-stream" : found->second;
}

/// No hidden file, no way up, nothing that a file system reads differently than we do.
bool is_plain_name(std::string_view segment) {
  return !segment.empty() && !segment.starts_with('.') &&
         segment.find_first_of(std::string_view("/\\\0", 3)) == std::string_view::npos;
}

/// Weak, because a compressed answer carries the same tag.
std::string entity_tag(const std::filesystem::path& path, std::size_t size) {
  std::error_code ignored;
  const auto changed = std::filesystem::last_write_time(path, ignored).time_since_epoch().count();
  return "W/\"" + std::to_string(changed) + "-" + std::to_string(size) + "\"";
}

}  // namespace

void StaticFiles::mount(std::string_view prefix, std::filesystem::path root) {
  PathSegments segments;
  if (!prefix.empty()) segments = split_path("/" + std::string(prefix)).value();
  mounts_.push_back({std::move(segments), std::move(root)});
}

std::optional<std::filesystem::path> StaticFiles::find(const PathSegments& path) const {
  for (const Mount& mount : mounts_) {
    if (path.size() <= mount.prefix.size()) continue;
    const auto [prefix_end, rest] = std::ranges::mismatch(mount.prefix, path);
    if (prefix_end != mount.prefix.end()) continue;
    std::filesystem::path file = mount.root;
    const bool is_index = rest->empty() && std::next(rest) == path.end();
    if (is_index) {
      file /= "index.html";
    } else if (std::all_of(rest, path.end(), is_plain_name)) {
      for (auto segment = rest; segment != path.end(); ++segment) file /= *segment;
    } else {
      continue;
    }
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) return file;
  }
  return std::nullopt;
}

std::optional<Response> StaticFiles::get(const PathSegments& path,
                                         std::string_view if_none_match) const {
  const auto file = find(path);
  if (!file) return std::nullopt;
  std::ifstream stream(*file, std::ios::binary);
  if (!stream) return std::nullopt;
  Response response{.content_type = content_type_of(*file),
                    .body = std::string(std::istreambuf_iterator<char>(stream), {})};
  const std::string tag = entity_tag(*file, response.body.size());
  // "no-cache" means: ask each time whether it changed, so an upgrade shows at once.
  response.headers = {{"ETag", tag}, {"Cache-Control", "no-cache"}};
  if (names_entity_tag(if_none_match, tag)) {
    response.status = 304;
    response.body.clear();
  }
  return response;
}

}  // namespace cornerfix::server
