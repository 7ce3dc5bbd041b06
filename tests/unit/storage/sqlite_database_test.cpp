#include "storage/sqlite/sqlite_database.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <barrier>
#include <csignal>
#include <thread>

#include "storage/map_store.hpp"
#include "storage/sqlite/schema.hpp"
#include "unit/storage/storage_samples.hpp"

namespace cornerfix::storage {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Key;

constexpr int kOneMillisecond = 1;

/// A closed database with a map in it.
void make_database(const fs::path& path) {
  MapStore store(open_database(path));
  const MapInfo map = [&] {
    (void)store.put("office", "second floor", std::nullopt, std::nullopt, "t0").value();
    return store.find("office").value();
  }();
  const std::vector<PosedScan> key_frames = sample_key_frames(60);
  (void)store.grow(map.id, map.revision, {.stamps = {}, .new_key_frames = key_frames}, "t1")
      .value();
}

/// A closed SQLite file, made by `sql` and in WAL mode.
void make_sqlite_file(const fs::path& path, const std::string& sql) {
  SQLite::Database database(path.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  database.exec("PRAGMA journal_mode = WAL");
  database.exec(sql);
}

/// What a killed process leaves of a database: the file and its unmerged WAL, without the index.
void copy_as_killed(const fs::path& from, const fs::path& to) {
  fs::copy_file(from, to);
  fs::copy_file(from.string() + "-wal", to.string() + "-wal");
}

void expect_refused_untouched(const TempDirectory& directory, const fs::path& path, ErrorCode code,
                              const std::string& message) {
  const auto before = directory.snapshot();
  const auto opened = SqliteDatabase::open(path, Synchronous::kFull);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, code) << opened.error().message;
  EXPECT_THAT(opened.error().message, HasSubstr(message));
  EXPECT_EQ(opened.error().field, path.string());
  EXPECT_TRUE(directory.snapshot() == before) << "a refused file must stay as it was";
}

TEST(SqliteDatabase, CreatesAFileOfOurs) {
  const TempDirectory directory;
  const auto database = open_database(directory / "new.db");
  SQLite::Database& connection = database->connection();
  EXPECT_EQ(connection.execAndGet("PRAGMA application_id").getInt64(), kApplicationId);
  EXPECT_EQ(connection.execAndGet("PRAGMA user_version").getInt64(), schema_version());
}

TEST(SqliteDatabase, LeavesOneFileWhenClosed) {
  const TempDirectory directory;
  make_database(directory / "maps.db");
  EXPECT_THAT(directory.snapshot(), ElementsAre(Key("maps.db")));
}

TEST(SqliteDatabase, SetsThePragmasThatTheStoresRelyOn) {
  const TempDirectory directory;
  for (const auto& [synchronous, level] :
       {std::pair(Synchronous::kFull, 2), std::pair(Synchronous::kNormal, 1)}) {
    const auto database = open_database(directory / "new.db", synchronous);
    SQLite::Database& connection = database->connection();
    EXPECT_EQ(connection.execAndGet("PRAGMA journal_mode").getString(), "wal");
    EXPECT_EQ(connection.execAndGet("PRAGMA foreign_keys").getInt(), 1);
    EXPECT_EQ(connection.execAndGet("PRAGMA busy_timeout").getInt(), kDefaultBusyTimeoutMs);
    EXPECT_EQ(connection.execAndGet("PRAGMA synchronous").getInt(), level);
  }
}

TEST(SqliteDatabase, TakesAnEmptyFileForANewOne) {
  const TempDirectory directory;
  write_bytes(directory / "empty.db", "");
  EXPECT_TRUE(SqliteDatabase::open(directory / "empty.db", Synchronous::kFull));
}

TEST(SqliteDatabase, OpensNamesThatWouldMeanSomethingElseInAUri) {
  const TempDirectory directory;
  for (const std::string name : {"what?.db", "100%41.db", "a#b.db", ":memory:"}) {
    make_database(directory / name);
    MapStore store(open_database(directory / name));
    EXPECT_TRUE(store.find("office")) << name;
  }
}

TEST(SqliteDatabase, ReopensItsOwnFileUnchanged) {
  const TempDirectory directory;
  make_database(directory / "maps.db");
  const auto before = directory.snapshot();
  (void)open_database(directory / "maps.db");
  EXPECT_TRUE(directory.snapshot() == before);
}

TEST(SqliteDatabase, RefusesAMissingDirectory) {
  const TempDirectory directory;
  const auto opened = SqliteDatabase::open(directory / "nowhere/maps.db", Synchronous::kFull);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnavailable);
}

TEST(SqliteDatabase, RefusesADirectory) {
  const TempDirectory directory;
  EXPECT_FALSE(SqliteDatabase::open(directory.path(), Synchronous::kFull));
}

TEST(SqliteDatabase, RefusesWhatIsNotSqlite) {
  const TempDirectory directory;
  for (const std::string& bytes : {std::string(2, 'x'), std::string(99, 'x'),
                                   std::string(20000, 'x'), std::string(4096, '\0')}) {
    write_bytes(directory / "notes.txt", bytes);
    expect_refused_untouched(directory, directory / "notes.txt", ErrorCode::kCorruptData,
                             "not a database");
  }
}

// SQLite itself takes a file of one byte for an empty one.
TEST(SqliteDatabase, RefusesASingleByte) {
  const TempDirectory directory;
  write_bytes(directory / "notes.txt", "x");
  expect_refused_untouched(directory, directory / "notes.txt", ErrorCode::kCorruptData,
                           "not a database");
}

TEST(SqliteDatabase, RefusesAnSqliteFileOfAnotherProgram) {
  const TempDirectory directory;
  make_sqlite_file(directory / "other.db", "CREATE TABLE t (x); PRAGMA application_id = 77");
  expect_refused_untouched(directory, directory / "other.db", ErrorCode::kInvalidArgument,
                           "not a Cornerfix database");
}

TEST(SqliteDatabase, RefusesAnSqliteFileWithoutAnOwner) {
  const TempDirectory directory;
  make_sqlite_file(directory / "other.db", "CREATE TABLE t (x)");
  expect_refused_untouched(directory, directory / "other.db", ErrorCode::kInvalidArgument,
                           "not a Cornerfix database");
}

TEST(SqliteDatabase, RefusesANewerSchema) {
  const TempDirectory directory;
  make_database(directory / "maps.db");
  make_sqlite_file(directory / "maps.db", "PRAGMA user_version = 99");
  expect_refused_untouched(directory, directory / "maps.db", ErrorCode::kInvalidArgument,
                           "schema 99");
}

TEST(SqliteDatabase, RefusesANewerSchemaThatIsInTheWalOnly) {
  const TempDirectory directory;
  const TempDirectory source;
  make_database(source / "maps.db");
  {
    SQLite::Database newer((source / "maps.db").string(), SQLite::OPEN_READWRITE);
    newer.exec("PRAGMA user_version = 99");
    copy_as_killed(source / "maps.db", directory / "maps.db");
  }
  expect_refused_untouched(directory, directory / "maps.db", ErrorCode::kInvalidArgument,
                           "schema 99");
}

TEST(SqliteDatabase, RefusesANewerSchemaWhileAnotherProcessHasItOpen) {
  const TempDirectory directory;
  make_database(directory / "maps.db");
  SQLite::Database newer((directory / "maps.db").string(), SQLite::OPEN_READWRITE);
  newer.exec("PRAGMA user_version = 99");
  const std::string file = read_bytes(directory / "maps.db");
  const std::string wal = read_bytes(directory / "maps.db-wal");
  EXPECT_FALSE(SqliteDatabase::open(directory / "maps.db", Synchronous::kFull));
  EXPECT_EQ(read_bytes(directory / "maps.db"), file);
  EXPECT_EQ(read_bytes(directory / "maps.db-wal"), wal);
}

TEST(SqliteDatabase, RefusesATruncatedFile) {
  const TempDirectory directory;
  make_database(directory / "maps.db");
  const std::string whole = read_bytes(directory / "maps.db");
  for (const std::size_t size :
       {std::size_t{100}, std::size_t{4096}, whole.size() / 2, whole.size() - 4096}) {
    write_bytes(directory / "maps.db", whole.substr(0, size));
    expect_refused_untouched(directory, directory / "maps.db", ErrorCode::kCorruptData, "database");
  }
}

TEST(SqliteDatabase, RefusesAFileWithAnOverwrittenPage) {
  const TempDirectory directory;
  make_database(directory / "maps.db");
  const std::string whole = read_bytes(directory / "maps.db");
  for (const std::size_t page : {1U, 2U, 3U, 4U}) {
    std::string damaged = whole;
    damaged.replace(page * 4096, 64, 64, '\xA5');
    write_bytes(directory / "maps.db", damaged);
    expect_refused_untouched(directory, directory / "maps.db", ErrorCode::kCorruptData, "database");
  }
}

TEST(SqliteDatabase, GoesOnFromTheWalOfAKilledProcess) {
  const TempDirectory directory;
  const TempDirectory source;
  {
    MapStore store(open_database(source / "maps.db"));
    ASSERT_TRUE(store.put("office", std::nullopt, std::nullopt, std::nullopt, "now"));
    copy_as_killed(source / "maps.db", directory / "maps.db");
  }
  MapStore store(open_database(directory / "maps.db"));
  EXPECT_TRUE(store.find("office"));
}

/// Page `number`, from 1, as the last frame of the WAL that holds it has it (SQLite file format,
/// section 4).
std::string page_in_wal(const std::string& wal, std::uint32_t number, std::size_t page_size) {
  constexpr std::size_t kWalHeader = 32;
  constexpr std::size_t kFrameHeader = 24;
  const auto big_endian = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = value << 8U | static_cast<unsigned char>(wal.at(at + i));
    return value;
  };
  std::string page;
  for (std::size_t frame = kWalHeader; frame + kFrameHeader + page_size <= wal.size();
       frame += kFrameHeader + page_size) {
    if (big_endian(frame) == number) page = wal.substr(frame + kFrameHeader, page_size);
  }
  return page;
}

// A checkpoint writes page 1 first, whose page count then exceeds the file's length.
TEST(SqliteDatabase, GoesOnAfterACheckpointThatWroteTheFirstPageOnly) {
  const TempDirectory directory;
  const TempDirectory source;
  {
    MapStore store(open_database(source / "maps.db"));
    ASSERT_TRUE(store.put("office", std::nullopt, std::nullopt, std::nullopt, "now"));
    const MapInfo map = store.find("office").value();
    ASSERT_TRUE(store.grow(map.id, map.revision,
                           {.stamps = {}, .new_key_frames = sample_key_frames(60)}, "now"));
    copy_as_killed(source / "maps.db", directory / "maps.db");
  }
  std::string file = read_bytes(directory / "maps.db");
  const std::string first_page =
      page_in_wal(read_bytes(directory / "maps.db-wal"), 1, std::size_t{4096});
  ASSERT_EQ(first_page.size(), 4096U);
  ASSERT_NE(first_page, file.substr(0, 4096));
  file.replace(0, 4096, first_page);
  write_bytes(directory / "maps.db", file);
  MapStore store(open_database(directory / "maps.db"));
  const auto key_frames = store.key_frames(store.find("office")->id);
  ASSERT_TRUE(key_frames) << key_frames.error().message;
  EXPECT_EQ(key_frames->size(), 60U);
}

TEST(SqliteDatabase, RollsBackWhatAKilledMigrationLeft) {
  const TempDirectory directory;
  const TempDirectory source;
  make_database(source / "maps.db");
  {
    SQLite::Database migrating((source / "maps.db").string(), SQLite::OPEN_READWRITE);
    migrating.exec("PRAGMA journal_mode = DELETE");
    // So small a cache writes pages to the file before the commit.
    migrating.exec("PRAGMA cache_size = 1; BEGIN; UPDATE key_frames SET scan = zeroblob(9000)");
    fs::copy_file(source / "maps.db", directory / "maps.db");
    fs::copy_file(source / "maps.db-journal", directory / "maps.db-journal");
  }
  MapStore store(open_database(directory / "maps.db"));
  const auto key_frames = store.key_frames(store.find("office")->id);
  ASSERT_TRUE(key_frames) << key_frames.error().message;
  EXPECT_EQ(key_frames->size(), 60U);
}

TEST(SqliteDatabase, KeepsWhatItAcknowledgedWhenTheProcessIsKilled) {
  const TempDirectory directory;
  const fs::path path = directory / "maps.db";
  std::array<int, 2> acknowledged{};
  ASSERT_EQ(::pipe(acknowledged.data()), 0);
  const pid_t writer = ::fork();
  if (writer == 0) {
    MapStore store(open_database(path));
    for (int i = 0;; ++i) {
      (void)store.put(std::to_string(i), "", "", "", "now").value();
      (void)!::write(acknowledged[1], "+", 1);
    }
  }
  ::close(acknowledged[1]);  // So that a writer that fails ends the reading too.
  constexpr int kAcknowledged = 20;
  char answer = 0;
  for (int i = 0; i < kAcknowledged; ++i) ASSERT_EQ(::read(acknowledged[0], &answer, 1), 1);
  ::kill(writer, SIGKILL);
  ::waitpid(writer, nullptr, 0);
  ::close(acknowledged[0]);

  MapStore store(open_database(path));
  for (int i = 0; i < kAcknowledged; ++i) EXPECT_TRUE(store.find(std::to_string(i))) << i;
}

TEST(SqliteDatabase, OpensWhileAnotherConnectionIsOpen) {
  const TempDirectory directory;
  const auto first = open_database(directory / "maps.db");
  MapStore store(first);
  ASSERT_TRUE(store.put("office", std::nullopt, std::nullopt, std::nullopt, "now"));
  MapStore second(open_database(directory / "maps.db"));
  EXPECT_TRUE(second.find("office"));
}

TEST(SqliteDatabase, IsCreatedOnceByProcessesThatStartTogether) {
  const TempDirectory directory;
  constexpr int kThreads = 6;
  std::barrier start(kThreads);
  std::vector<std::string> errors(kThreads);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i) {
      threads.emplace_back([&, i] {
        start.arrive_and_wait();
        const auto database = SqliteDatabase::open(directory / "maps.db", Synchronous::kFull);
        if (!database) errors[static_cast<std::size_t>(i)] = database.error().message;
      });
    }
  }
  EXPECT_EQ(errors, std::vector<std::string>(kThreads));
}

TEST(SqliteDatabase, OpensAnotherConnectionToTheSameFile) {
  const TempDirectory directory;
  const auto first = open_database(directory / "maps.db");
  MapStore store(first->open_another(Synchronous::kFull).value());
  ASSERT_TRUE(store.put("office", std::nullopt, std::nullopt, std::nullopt, "now"));
  EXPECT_TRUE(MapStore(first).find("office"));
}

TEST(SqliteDatabase, TellsWhenAnotherConnectionChangedTheFile) {
  const TempDirectory directory;
  const auto database = open_database(directory / "maps.db");
  MapStore other(open_database(directory / "maps.db"));
  const std::int64_t before = database->data_version().value();
  ASSERT_TRUE(other.put("office", std::nullopt, std::nullopt, std::nullopt, "now"));
  EXPECT_NE(database->data_version().value(), before);
}

TEST(SqliteDatabase, DoesNotTellOfItsOwnChanges) {
  const TempDirectory directory;
  const auto database = open_database(directory / "maps.db");
  const std::int64_t before = database->data_version().value();
  ASSERT_TRUE(MapStore(database).put("office", std::nullopt, std::nullopt, std::nullopt, "now"));
  EXPECT_EQ(database->data_version().value(), before);
}

TEST(SqliteDatabase, IsReady) {
  const TempDirectory directory;
  EXPECT_TRUE(open_database(directory / "maps.db")->probe());
}

TEST(SqliteDatabase, IsNotReadyOnceANewerProgramMigratedTheFile) {
  const TempDirectory directory;
  const auto database = open_database(directory / "maps.db");
  make_sqlite_file(directory / "maps.db", "PRAGMA user_version = 99");
  const Result<void> ready = database->probe();
  ASSERT_FALSE(ready);
  EXPECT_EQ(ready.error().code, ErrorCode::kUnavailable);
}

TEST(SqliteDatabase, SaysBusyWhenAnotherWriterDoesNotEnd) {
  const TempDirectory directory;
  const auto first = open_database(directory / "maps.db");
  MapStore store(
      SqliteDatabase::open(directory / "maps.db", Synchronous::kNormal, kOneMillisecond).value());
  const SQLite::Transaction writer(first->connection(), SQLite::TransactionBehavior::IMMEDIATE);
  const auto put = store.put("office", std::nullopt, std::nullopt, std::nullopt, "now");
  ASSERT_FALSE(put);
  EXPECT_EQ(put.error().code, ErrorCode::kUnavailable);
}

TEST(SqliteDatabase, EndsForeignExceptionsAsErrors) {
  const Result<int> result = guarded([]() -> Result<int> { throw std::bad_alloc(); });
  EXPECT_EQ(result.error().code, ErrorCode::kInternal);
}

}  // namespace
}  // namespace cornerfix::storage
