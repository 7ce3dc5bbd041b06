/// \file  Maps of a server, made from the scans of a log or from an occupancy map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <cornerfix/map_image.hpp>

#include "clients/cpp/server_connection.hpp"
#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::client {

/// What a batch of scans added, and the state of the map after it.
struct MapGrowth {
  std::size_t accepted = 0;
  std::size_t duplicates = 0;  ///< Scans whose stamps the map holds already.
  std::size_t keyframes = 0;
  std::size_t features = 0;
  std::uint64_t revision = 0;
};

/// What a map has already. A later run does not change description and lidar, and a run into an
/// occupancy map will be refused.
struct KnownOfMap {
  bool description = false;
  bool lidar = false;
  bool is_occupancy_map = false;
};

/// Body of PUT /v1/maps/{map} with the description and lidar that the map does not have; nothing
/// when it has both.
[[nodiscard]] std::optional<std::string> description_body(const std::string& description,
                                                          const evaluation::LogHeader& header,
                                                          const std::optional<KnownOfMap>& known);

/// Scans of one log into one map. The connection outlives it. One thread at a time.
class MapUpload {
 public:
  MapUpload(const std::string& map, evaluation::LogHeader header, ServerConnection& server);

  /// Makes the map, or adds the description and lidar that it does not have.
  [[nodiscard]] Result<void> describe(const std::string& description);
  /// \param without_poses  The server finds the poses.
  [[nodiscard]] Result<MapGrowth> add(std::span<const evaluation::LogScan> scans,
                                      bool without_poses);
  /// Number of features; optimizes the trajectory of a map that was made without poses.
  [[nodiscard]] Result<std::size_t> count_features();

 private:
  std::string path_;
  evaluation::LogHeader header_;
  ServerConnection& server_;
};

/// What an occupancy map became on the server.
struct ImportedMap {
  std::size_t features = 0;
  std::uint64_t revision = 0;
  std::vector<std::string> warnings;
};

/// PUT /v1/maps/{map}/grid. An image above 15 MiB is sent as png.
[[nodiscard]] Result<ImportedMap> upload_occupancy_map(ServerConnection& server,
                                                       const std::string& map,
                                                       const std::string& yaml_path,
                                                       MapFiles files);

}  // namespace cornerfix::client
