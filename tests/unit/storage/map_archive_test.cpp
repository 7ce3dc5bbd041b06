#include "storage/map_archive.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <functional>

#include "storage/database.hpp"
#include "storage/map_store.hpp"
#include "storage/sqlite/backup.hpp"
#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::HasSubstr;

/// Keyframes that a lidar can have taken.
std::vector<PosedScan> possible_key_frames(int count) {
  std::vector<PosedScan> key_frames;
  for (int i = 0; i < count; ++i) {
    LaserScan scan{10.0 + i, -1.5, 0.5, 0.1, 20.0, {1.0F, 2.0F, 3.5F, 4.0F, 1.0F}};
    key_frames.push_back({scan, Pose2{0.1, 0.0, 0.0}, Pose2{0.5 * i, 1.0, 0.25}});
  }
  return key_frames;
}

OccupancyGrid possible_grid() {
  OccupancyGrid grid{
      .resolution = 0.1, .T_map_grid = {1, 2, 0.5}, .width = 3, .height = 2, .cells = {}};
  grid.cells = {Cell::kFree,     Cell::kFree, Cell::kOccupied,
                Cell::kOccupied, Cell::kFree, Cell::kUnknown};
  return grid;
}

class MapArchiveTest : public ::testing::Test {
 protected:
  MapArchiveTest() {
    EXPECT_TRUE(store_.put("office", "ground floor", std::nullopt, std::nullopt, "t0"));
    const MapInfo map = store_.find("office").value();
    const auto key_frames = possible_key_frames(3);
    const std::vector<double> stamps{9.0, 10.0, 11.0, 12.0};
    MapGrowth growth;
    growth.stamps = stamps;
    growth.new_key_frames = key_frames;
    EXPECT_TRUE(store_.grow(map.id, map.revision, growth, "t1"));
  }

  MapInfo grow_drive(const std::string& name, const std::vector<PosedScan>& key_frames) {
    EXPECT_TRUE(store_.put(name, std::nullopt, std::nullopt, std::nullopt, "t0"));
    const MapInfo map = store_.find(name).value();
    const std::vector<double> stamps{9.0, 10.0, 11.0, 12.0};
    MapGrowth growth;
    growth.stamps = stamps;
    growth.new_key_frames = key_frames;
    growth.drifts = true;
    return store_.grow(map.id, map.revision, growth, "t1").value();
  }

  std::vector<std::uint8_t> archive_bytes(const std::string& name = "office") {
    return encode_archive(store_.archive(name).value()).value();
  }

  /// Why the archive is refused after `sql` has been run on it; "" when it is taken.
  std::string refusal_after(const std::string& sql) {
    const auto path = directory_ / "hostile.cornerfix";
    const auto bytes = archive_bytes();
    write_bytes(path, {bytes.begin(), bytes.end()});
    SQLite::Database(path.string(), SQLite::OPEN_READWRITE).exec(sql);
    const std::string hostile = read_bytes(path);
    return refusal_of({hostile.begin(), hostile.end()});
  }

  static std::string refusal_of(const std::vector<std::uint8_t>& bytes) {
    const auto archive = decode_archive(bytes);
    if (archive) return "";
    EXPECT_EQ(archive.error().field, "archive");
    EXPECT_TRUE(archive.error().code == ErrorCode::kMalformed ||
                archive.error().code == ErrorCode::kInvalidArgument);
    return archive.error().message;
  }

  TempDirectory directory_;
  std::shared_ptr<Database> database_ = open_database(directory_ / "maps.db");
  MapStore store_{database_};
};

TEST_F(MapArchiveTest, AMapOfScansComesBackWithItsDigest) {
  const MapInfo before = store_.find("office").value();
  const MapArchive archive = decode_archive(archive_bytes()).value();
  const MapInfo restored = store_.restore("copy", archive, {}, "t2").value();
  EXPECT_EQ(restored.digest, before.digest);
  EXPECT_EQ(restored.revision, before.revision);
  EXPECT_EQ(store_.find("copy")->digest, before.digest);
  EXPECT_EQ(store_.find("copy")->description, "ground floor");
  EXPECT_TRUE(is_same(store_.key_frames(restored.id).value(), possible_key_frames(3)));
  const std::vector<double> stamps{9.0, 12.0, 13.0};
  EXPECT_THAT(store_.known_stamps(restored.id, stamps).value(),
              ::testing::ElementsAre(true, true, false));
}

TEST_F(MapArchiveTest, AMapOfAFloorMapComesBackWithItsDigest) {
  ASSERT_TRUE(store_.put_floor_map("plan", {.grid = possible_grid()}, "t1"));
  const MapArchive archive = decode_archive(archive_bytes("plan")).value();
  const MapInfo restored = store_.restore("copy", archive, {}, "t2").value();
  EXPECT_EQ(restored.digest, store_.find("plan")->digest);
  EXPECT_EQ(store_.floor_map(restored.id).value(), possible_grid());
}

TEST_F(MapArchiveTest, AMapThatDriftsComesBackAsSuchWithItsDigest) {
  const MapInfo before = grow_drive("drive", possible_key_frames(3));
  const MapArchive archive = decode_archive(archive_bytes("drive")).value();
  const MapInfo restored = store_.restore("copy", archive, {}, "t2").value();
  EXPECT_TRUE(restored.drifts);
  EXPECT_TRUE(store_.find("copy")->drifts);
  EXPECT_EQ(restored.digest, before.digest);
  EXPECT_NE(restored.digest, store_.find("office")->digest);  // The same scans, at poses.
}

TEST_F(MapArchiveTest, RefusesADriveWithoutPosesThatGoesBackInTime) {
  std::vector<PosedScan> key_frames = possible_key_frames(3);
  std::swap(key_frames[1].scan.stamp, key_frames[2].scan.stamp);
  grow_drive("drive", key_frames);
  EXPECT_THAT(refusal_of(archive_bytes("drive")), HasSubstr("key frame 2: a drive without poses"));
}

TEST_F(MapArchiveTest, IsNotRestoredOverAnotherMap) {
  const MapArchive archive = decode_archive(archive_bytes()).value();
  EXPECT_EQ(store_.restore("office", archive, {}, "t2").error().code, ErrorCode::kConflict);
}

TEST_F(MapArchiveTest, TakesWhatWasNotTamperedWith) { EXPECT_EQ(refusal_after(""), ""); }

TEST_F(MapArchiveTest, RefusesWhatIsNotAnArchive) {
  EXPECT_THAT(refusal_of({}), HasSubstr("not an SQLite file"));
  EXPECT_THAT(refusal_of(std::vector<std::uint8_t>(4096, 7)), HasSubstr("not an SQLite file"));
  EXPECT_THAT(refusal_after("PRAGMA application_id = 7"), HasSubstr("application_id"));
  EXPECT_THAT(refusal_after("PRAGMA user_version = 2"), HasSubstr("version 2"));
}

TEST_F(MapArchiveTest, RefusesEverySchemaButItsOwn) {
  for (const char* sql :
       {"CREATE TABLE more (x)", "CREATE VIEW v AS SELECT 1", "DROP TABLE stamps",
        "CREATE TRIGGER t AFTER INSERT ON map BEGIN DELETE FROM map; END",
        "CREATE INDEX i ON map (digest)", "DROP TABLE map; CREATE VIEW map AS SELECT 1",
        "ALTER TABLE map ADD COLUMN more TEXT", "CREATE VIRTUAL TABLE f USING fts5(x)"}) {
    EXPECT_THAT(refusal_after(sql), HasSubstr("tables")) << sql;
  }
}

TEST_F(MapArchiveTest, RefusesContentThatCannotBe) {
  const std::pair<const char*, const char*> cases[] = {
      {"DELETE FROM map", "no map"},
      {"INSERT INTO map SELECT * FROM map", "more than one map"},
      {"UPDATE map SET revision = 0", "revision"},
      {"UPDATE map SET revision = 9223372036854775807", "revision"},
      {"UPDATE map SET digest = 'x'", "digest"},
      {"UPDATE map SET parameters_json = '{}'", "digest"},
      {"UPDATE key_frames SET scan = x'0101' WHERE ordinal = 1",
       "key frame 1: key frame: cut short"},
      {"UPDATE key_frames SET scan = zeroblob(100) WHERE ordinal = 1", "key frame 1"},
      {"DELETE FROM key_frames WHERE ordinal = 1", "key frame 1 is missing"},
      {"DELETE FROM key_frames WHERE ordinal = 2", "digest"},
      {"DELETE FROM stamps WHERE stamp = 11", "its stamp"},
      {"INSERT INTO stamps VALUES (9e999)", "not finite"},
      {"INSERT INTO floor_map VALUES (zeroblob(40))", "floor map"},
      {"UPDATE map SET drifts = 1", "digest"},
      {"UPDATE map SET drifts = 2", "drifts"},
      {"DELETE FROM key_frames; UPDATE map SET drifts = 1", "drifts without a key frame"},
  };
  for (const auto& [sql, reason] : cases) {
    EXPECT_THAT(refusal_after(sql), HasSubstr(reason)) << sql;
  }
}

TEST_F(MapArchiveTest, RefusesAFileThatWasCutShortAnywhere) {
  const auto bytes = archive_bytes();
  for (std::size_t size = 0; size < bytes.size(); size += 251) {
    EXPECT_NE(refusal_of({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}), "")
        << size;
  }
}

TEST_F(MapArchiveTest, NeverTakesDamagedBytesForOtherContent) {
  const MapArchive archive = decode_archive(archive_bytes()).value();
  const auto bytes = archive_bytes();
  for (std::size_t i = 0; i < bytes.size(); i += 13) {
    auto damaged = bytes;
    damaged[i] ^= 0x55U;
    const auto decoded = decode_archive(damaged);
    if (!decoded) continue;  // A byte that nothing reads does no harm.
    EXPECT_EQ(decoded->digest, archive.digest) << i;
    EXPECT_TRUE(is_same(decoded->key_frames, archive.key_frames)) << i;
  }
}

TEST_F(MapArchiveTest, AnOpenDatabaseIsBackedUpWhole) {
  const auto copy = directory_ / "copy.db";
  ASSERT_TRUE(back_up(directory_ / "maps.db", copy));
  MapStore store(open_database(copy));
  EXPECT_EQ(store.find("office")->digest, store_.find("office")->digest);
}

TEST_F(MapArchiveTest, ABackUpOverwritesNothingAndCopiesNoOtherFile) {
  const auto other = directory_ / "other.db";
  SQLite::Database(other.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec("CREATE TABLE t (x)");
  const auto before = directory_.snapshot();
  EXPECT_EQ(back_up(directory_ / "maps.db", other).error().code, ErrorCode::kConflict);
  EXPECT_EQ(back_up(other, directory_ / "copy.db").error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(back_up(directory_ / "maps.db", directory_ / "none" / "copy.db").error().message,
              ::testing::HasSubstr("none/copy.db: "));
  EXPECT_EQ(back_up(directory_ / "none.db", directory_ / "copy.db").error().code,
            ErrorCode::kNotFound);
  EXPECT_EQ(directory_.snapshot(), before);
}

}  // namespace
}  // namespace cornerfix::storage
