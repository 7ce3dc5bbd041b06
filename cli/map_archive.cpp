#include "cli/map_archive.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "cli/command.hpp"
#include "server/responses.hpp"

namespace cornerfix::cli {

namespace {

std::string archive_path(const std::string& map) {
  return "/v1/maps/" + client::percent_encode(map) + "/archive";
}

/// Whole or not at all: what was there stays until the last byte is written.
Result<void> write_file(const std::string& path, const std::string& bytes) {
  const std::string partial = path + ".partial";
  std::ofstream file(partial, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(partial, path, error);
  if (file && !error) return {};
  std::filesystem::remove(partial, error);
  return Error{ErrorCode::kUnavailable, "cannot be written", path};
}

Result<std::string> read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) return Error{ErrorCode::kUnavailable, "cannot be read", path};
  return bytes;
}

}  // namespace

int run_map_export(const MapArchiveArguments& arguments) {
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  client::HttpRequest request{"GET", archive_path(arguments.name)};
  request.answer_path = arguments.file;
  const Result<std::string> bytes = server->fetch(request);
  if (!bytes) return fail(bytes.error());
  if (server->is_printing()) return kDone;
  if (const auto written = write_file(arguments.file, *bytes); !written)
    return fail(written.error());
  std::printf("%s: %zu bytes in %s\n", arguments.name.c_str(), bytes->size(),
              arguments.file.c_str());
  return kDone;
}

int run_map_restore(const MapArchiveArguments& arguments) {
  Result<std::string> bytes = read_file(arguments.file);
  if (!bytes) return fail(bytes.error());
  if (bytes->empty())
    return fail({ErrorCode::kInvalidArgument, "is empty, so it is no map", arguments.file});
  Result<client::ServerConnection> server = client::ServerConnection::open(arguments.connection);
  if (!server) return fail(server.error());
  client::HttpRequest request{"POST", archive_path(arguments.name), std::move(*bytes)};
  request.content_type = server::kArchiveType;
  request.body_path = arguments.file;
  const Result<nlohmann::json> map = server->call(request);
  if (!map) return fail(map.error());
  if (server->is_printing()) return kDone;
  std::printf("%s: restored, digest %s\n", arguments.name.c_str(),
              map->value("digest", std::string()).c_str());
  return kDone;
}

}  // namespace cornerfix::cli
