#include "storage/map_archive.hpp"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "storage/blob_codec.hpp"
#include "storage/database.hpp"
#include "storage/digest.hpp"
#include "storage/sqlite/database_image.hpp"

namespace cornerfix::storage {
namespace {

constexpr ImageKind kArchiveKind{.application_id = 0x43464941,  // "CFIA"
                                 .version = 1,
                                 .schema = R"sql(
CREATE TABLE map (
  description     TEXT    NOT NULL,
  revision        INTEGER NOT NULL,
  digest          TEXT    NOT NULL,
  lidar_json      TEXT    NOT NULL,
  parameters_json TEXT    NOT NULL,
  drifts          INTEGER NOT NULL
) STRICT;
CREATE TABLE key_frames (
  ordinal INTEGER PRIMARY KEY,
  scan    BLOB    NOT NULL
) STRICT;
CREATE TABLE stamps (
  stamp REAL NOT NULL PRIMARY KEY
) STRICT, WITHOUT ROWID;
CREATE TABLE floor_map (
  grid BLOB NOT NULL
) STRICT;
)sql"};

Error refused(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message), "archive"};
}

void bind_blob(SQLite::Statement& statement, int index, const Blob& blob) {
  statement.bindNoCopy(index, blob.data(), static_cast<int>(blob.size()));
}

BlobView blob_at(SQLite::Statement& statement, int column) {
  const SQLite::Column value = statement.getColumn(column);
  return {static_cast<const std::uint8_t*>(value.getBlob()),
          static_cast<std::size_t>(value.getBytes())};
}

void write(SQLite::Database& image, const MapArchive& archive) {
  SQLite::Transaction transaction(image);
  SQLite::Statement map(image, "INSERT INTO map VALUES (?, ?, ?, ?, ?, ?)");
  map.bind(1, archive.description);
  map.bind(2, static_cast<std::int64_t>(archive.revision));
  map.bind(3, archive.digest);
  map.bind(4, archive.lidar_json);
  map.bind(5, archive.parameters_json);
  map.bind(6, archive.drifts ? 1 : 0);
  map.exec();
  SQLite::Statement key_frame(image, "INSERT INTO key_frames VALUES (?, ?)");
  for (std::size_t i = 0; i < archive.key_frames.size(); ++i) {
    const Blob blob = encode_key_frame(archive.key_frames[i]);
    key_frame.reset();
    key_frame.bind(1, static_cast<std::int64_t>(i));
    bind_blob(key_frame, 2, blob);
    key_frame.exec();
  }
  SQLite::Statement stamp(image, "INSERT INTO stamps VALUES (?)");
  for (const double value : archive.stamps) {
    stamp.reset();
    stamp.bind(1, value);
    stamp.exec();
  }
  if (archive.floor_map) {
    const Blob blob = encode_grid(*archive.floor_map);
    SQLite::Statement grid(image, "INSERT INTO floor_map VALUES (?)");
    bind_blob(grid, 1, blob);
    grid.exec();
  }
  transaction.commit();
}

constexpr std::int64_t kMaxRevision = std::int64_t{1} << 53;  // what a JSON number holds exactly

Result<void> read_map(SQLite::Database& image, MapArchive& archive) {
  SQLite::Statement map(
      image, "SELECT description, revision, digest, lidar_json, parameters_json, drifts FROM map");
  if (!map.executeStep()) return refused("the archive holds no map");
  const std::int64_t revision = map.getColumn(1).getInt64();
  if (revision < 1 || revision > kMaxRevision)
    return refused("the map's revision is not between 1 and 2^53");
  const std::int64_t drifts = map.getColumn(5).getInt64();
  if (drifts != 0 && drifts != 1) return refused("whether the map drifts is neither 0 nor 1");
  archive.description = map.getColumn(0).getString();
  archive.revision = static_cast<std::uint64_t>(revision);
  archive.digest = map.getColumn(2).getString();
  archive.lidar_json = map.getColumn(3).getString();
  archive.parameters_json = map.getColumn(4).getString();
  archive.drifts = drifts == 1;
  if (map.executeStep()) return refused("the archive holds more than one map");
  return {};
}

bool is_finite(const Pose2& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw);
}

/// What mapping has checked of every scan.
bool is_possible(const PosedScan& key_frame) {
  return !validate(key_frame.scan) && std::isfinite(key_frame.scan.stamp) &&
         is_finite(key_frame.T_map_base_link) && is_finite(key_frame.T_base_link_laser);
}

/// Returns the chain of the keyframes.
Result<KeyFrameChain> read_key_frames(SQLite::Database& image, MapArchive& archive) {
  KeyFrameChain chain{};
  SQLite::Statement statement(image, "SELECT ordinal, scan FROM key_frames ORDER BY ordinal");
  while (statement.executeStep()) {
    const std::size_t index = archive.key_frames.size();
    const std::string name = "key frame " + std::to_string(index);
    if (statement.getColumn(0).getInt64() != static_cast<std::int64_t>(index))
      return refused(name + " is missing");
    const BlobView blob = blob_at(statement, 1);
    Result<PosedScan> key_frame = decode_key_frame(blob);
    if (!key_frame) return refused(name + ": " + key_frame.error().message);
    if (!is_possible(*key_frame)) return refused(name + ": no lidar can have taken it");
    if (!std::ranges::binary_search(archive.stamps, key_frame->scan.stamp))
      return refused(name + ": its stamp is not among the map's");
    if (archive.drifts && index > 0 &&
        key_frame->scan.stamp <= archive.key_frames.back().scan.stamp)
      return refused(name + ": a drive without poses does not go back in time");
    archive.key_frames.push_back(std::move(*key_frame));
    chain = extend(chain, blob);
  }
  if (archive.drifts && archive.key_frames.empty())
    return refused("the map drifts without a key frame");
  return chain;
}

Result<void> read_stamps(SQLite::Database& image, MapArchive& archive) {
  SQLite::Statement statement(image, "SELECT stamp FROM stamps ORDER BY stamp");
  while (statement.executeStep()) archive.stamps.push_back(statement.getColumn(0).getDouble());
  const bool all_finite =
      std::ranges::all_of(archive.stamps, [](double stamp) { return std::isfinite(stamp); });
  if (!all_finite) return refused("a stamp is not finite");
  return {};
}

bool is_possible(const OccupancyGrid& grid) {
  return std::isfinite(grid.resolution) && grid.resolution > 0.0 && is_finite(grid.T_map_grid) &&
         grid.width > 0 && grid.height > 0;
}

Result<void> read_floor_map(SQLite::Database& image, MapArchive& archive) {
  SQLite::Statement statement(image, "SELECT grid FROM floor_map");
  if (!statement.executeStep()) return {};
  Result<OccupancyGrid> grid = decode_grid(blob_at(statement, 0));
  if (!grid) return refused("floor map: " + grid.error().message);
  if (!is_possible(*grid)) return refused("floor map: its size, resolution or origin cannot be");
  archive.floor_map = std::move(*grid);
  if (statement.executeStep()) return refused("the archive holds more than one floor map");
  if (!archive.stamps.empty()) return refused("the archive holds a floor map and scans as well");
  return {};
}

Result<MapArchive> read(SQLite::Database& image) {
  MapArchive archive;
  if (const auto done = read_map(image, archive); !done) return done.error();
  if (const auto done = read_stamps(image, archive); !done) return done.error();
  if (const auto done = read_floor_map(image, archive); !done) return done.error();
  const Result<KeyFrameChain> key_frames = read_key_frames(image, archive);
  if (!key_frames) return key_frames.error();
  const KeyFrameChain content = archive.floor_map ? hash_of(*archive.floor_map) : *key_frames;
  if (map_digest(archive.parameters_json, content, archive.drifts) != archive.digest)
    return refused("the content does not have the digest that the archive tells");
  return archive;
}

}  // namespace

Result<std::vector<std::uint8_t>> encode_archive(const MapArchive& archive) {
  return guarded([&]() -> Result<std::vector<std::uint8_t>> {
    const auto image = make_image(kArchiveKind);
    write(*image, archive);
    return bytes_of(*image);
  });
}

Result<MapArchive> decode_archive(std::span<const std::uint8_t> bytes) {
  auto image = open_untrusted_image(bytes, kArchiveKind);
  if (!image) return image.error();
  auto archive = guarded([&] { return read(**image); });
  // Damage that shows only now is in the sender's bytes, not in our own file.
  if (!archive && archive.error().field.empty())
    return Error{ErrorCode::kMalformed, archive.error().message, "archive"};
  return archive;
}

}  // namespace cornerfix::storage
