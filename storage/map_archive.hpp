/// \file  A whole map as one SQLite file: to carry it to another server, or to keep it.
///
/// docs/storage-schema.md describes the file's tables. Only the source of a map is in it; what is
/// derived is made again.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <cornerfix/laser_scan.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix::storage {

/// The source of a map, wherever it is stored.
struct MapArchive {
  std::string description;
  std::string lidar_json;       ///< Opaque to this module; empty for none.
  std::string parameters_json;  ///< The same.
  std::uint64_t revision = 1;
  std::string digest;          ///< Hex SHA-256 of the content, as in MapInfo.
  std::vector<double> stamps;  ///< Of all scans the map has taken, ascending.
  std::vector<PosedScan> key_frames;
  bool drifts = false;                     ///< Of the keyframes, as in MapInfo.
  std::optional<OccupancyGrid> floor_map;  ///< Instead of keyframes.
};

[[nodiscard]] Result<std::vector<std::uint8_t>> encode_archive(const MapArchive& archive);

/// Reads a file that anyone may have made: every table, BLOB and number is checked, and the content
/// must have the digest that it claims. kMalformed or kInvalidArgument, `field` "archive".
[[nodiscard]] Result<MapArchive> decode_archive(std::span<const std::uint8_t> bytes);

}  // namespace cornerfix::storage
