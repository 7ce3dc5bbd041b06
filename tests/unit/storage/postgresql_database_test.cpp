// PostgreSQL alone: other people's databases, migrations, and servers that go away.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <limits>

#include "storage/map_tables.hpp"
#include "storage/postgresql/postgresql_connection.hpp"
#include "storage/postgresql/postgresql_schema.hpp"
#include "storage/session_store.hpp"
#include "support/postgresql_server.hpp"
#include "unit/storage/engines.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class PostgresqlDatabaseTest : public EngineTest {
 protected:
  void TearDown() override {
    if (databases_.obstacle().empty() && !server().is_running()) server().start();
  }
  static testing::PostgresqlServer& server() { return testing::PostgresqlServer::shared(); }
  void expect_refused(const std::string& message) {
    const auto opened = databases_.try_open("maps");
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(opened.error().message, HasSubstr(message));
    EXPECT_THAT(opened.error().field, HasSubstr("postgresql://cornerfix@"));
  }
  Result<bool> put(MapStore& maps, const std::string& name) {
    return maps.put(name, std::nullopt, std::nullopt, std::nullopt, "t0");
  }
  /// Ends all other connections to the database, as an administrator can.
  void end_connections() {
    databases_.run("maps",
                   "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity "
                   "WHERE datname = current_database() AND pid <> pg_backend_pid()");
  }
};

INSTANTIATE_TEST_SUITE_P(Engines, PostgresqlDatabaseTest, ::testing::Values(Engine::kPostgresql),
                         EngineName());

TEST_P(PostgresqlDatabaseTest, RefusesTheTablesOfAnotherProgramAndLeavesThem) {
  databases_.run("maps", "CREATE TABLE maps (x TEXT)");
  expect_refused("1 tables of another program");
  EXPECT_EQ(
      databases_.run("maps", "SELECT count(*) FROM pg_tables WHERE schemaname = current_schema()"),
      1);
}

TEST_P(PostgresqlDatabaseTest, RefusesANewerSchema) {
  (void)databases_.open("maps");
  databases_.run("maps", "UPDATE cornerfix_schema SET version = 99");
  expect_refused("schema 99");
}

TEST_P(PostgresqlDatabaseTest, IsNotReadyOnceANewerProgramMigratedTheDatabase) {
  const auto database = databases_.open("maps");
  databases_.run("maps", "UPDATE cornerfix_schema SET version = 99");
  const Result<void> ready = database->probe();
  ASSERT_FALSE(ready);
  EXPECT_EQ(ready.error().code, ErrorCode::kUnavailable);
}

constexpr std::array<const char*, 2> kSteps = {
    "CREATE TABLE corners (x BIGINT NOT NULL); INSERT INTO corners VALUES (4)",
    "ALTER TABLE corners ADD COLUMN y BIGINT; UPDATE corners SET y = 2 * x"};

TEST_P(PostgresqlDatabaseTest, AppliesOnlyTheStepsThatADatabaseLacks) {
  PostgresqlConnection connection({.url = databases_.location("steps")});
  ASSERT_TRUE(migrate(connection, std::span(kSteps).first(1)));
  EXPECT_EQ(stored_schema_version(connection), 1);
  databases_.run("steps", "UPDATE corners SET x = 5");
  ASSERT_TRUE(migrate(connection, kSteps));
  EXPECT_EQ(stored_schema_version(connection), 2);
  EXPECT_EQ(databases_.run("steps", "SELECT y FROM corners"), 10);
}

TEST_P(PostgresqlDatabaseTest, TakesNoStepWhenOneOfThemFails) {
  constexpr std::array<const char*, 2> kBroken = {kSteps[0], "INSERT INTO nowhere VALUES (1)"};
  PostgresqlConnection connection({.url = databases_.location("steps")});
  EXPECT_THROW((void)migrate(connection, kBroken), StorageError);
  EXPECT_EQ(stored_schema_version(connection), 0);
  EXPECT_TRUE(migrate(connection, kSteps));
}

TEST_P(PostgresqlDatabaseTest, NeverShowsThePassword) {
  const std::string url = "postgresql://robot:secret@127.0.0.1:1/maps?connect_timeout=2";
  EXPECT_EQ(location_of(url).value(), "postgresql://robot@127.0.0.1:1/maps");
  const auto unreachable = Database::open(url, Synchronous::kFull);
  ASSERT_FALSE(unreachable);
  EXPECT_EQ(unreachable.error().code, ErrorCode::kUnavailable) << unreachable.error().message;
  EXPECT_THAT(unreachable.error().message, Not(HasSubstr("secret")));
  EXPECT_EQ(unreachable.error().field, "postgresql://robot@127.0.0.1:1/maps");
  const auto wrong = Database::open("postgresql://robot:sec%ret@host/maps", Synchronous::kFull);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(wrong.error().message + wrong.error().field, Not(HasSubstr("sec%ret")));
}

TEST_P(PostgresqlDatabaseTest, SaysThatThereIsNoSuchDatabase) {
  const auto missing = Database::open(server().url("nowhere"), Synchronous::kFull);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(missing.error().message, HasSubstr("\"nowhere\" does not exist"));
}

TEST_P(PostgresqlDatabaseTest, ConnectsAnewAfterTheServerEndedAnIdleConnection) {
  MapStore maps(databases_.open("maps"));
  ASSERT_TRUE(put(maps, "office"));
  end_connections();
  EXPECT_TRUE(maps.find("office"));
  end_connections();
  EXPECT_TRUE(put(maps, "lab"));
}

TEST_P(PostgresqlDatabaseTest, FailsACallThatLosesItsConnectionAndServesTheNext) {
  const auto database = databases_.open("maps");
  MapStore maps(database);
  {
    const auto transaction = database->begin(Access::kWrite);
    end_connections();
    const Result<void> lost = guarded([&]() -> Result<void> {
      database->maps().remove("office");
      return {};
    });
    ASSERT_FALSE(lost);
    EXPECT_EQ(lost.error().code, ErrorCode::kUnavailable);
    EXPECT_THAT(lost.error().message, HasSubstr("connection to PostgreSQL was lost"));
  }
  EXPECT_TRUE(put(maps, "office"));
}

TEST_P(PostgresqlDatabaseTest, KeepsWhatItAcknowledgedWhenTheServerCrashes) {
  MapStore maps(databases_.open("maps", Synchronous::kFull));
  ASSERT_TRUE(put(maps, "office"));
  server().crash();
  const auto unreachable = maps.find("office");
  ASSERT_FALSE(unreachable);
  EXPECT_EQ(unreachable.error().code, ErrorCode::kUnavailable) << unreachable.error().message;
  EXPECT_EQ(put(maps, "lab").error().code, ErrorCode::kUnavailable);
  server().start();
  EXPECT_TRUE(maps.find("office"));
  EXPECT_TRUE(put(maps, "lab"));
}

TEST_P(PostgresqlDatabaseTest, LeavesNothingInTheConnectionThatAPoolerWouldMix) {
  const auto database = databases_.open("maps", Synchronous::kNormal);
  MapStore maps(database);
  ASSERT_TRUE(put(maps, "office"));
  PostgresqlConnection connection({.url = databases_.location("maps"),
                                   .synchronous = Synchronous::kNormal,
                                   .busy_timeout_ms = 77});
  const auto setting = [&](const char* name) {
    return connection.execute("SELECT current_setting($1)", std::string_view(name)).text(0, 0);
  };
  const std::string before = setting("lock_timeout");
  connection.begin(Access::kWrite);
  EXPECT_EQ(setting("lock_timeout"), "77ms");
  EXPECT_EQ(setting("synchronous_commit"), "off");
  connection.commit();
  EXPECT_EQ(setting("lock_timeout"), before);
  EXPECT_EQ(setting("synchronous_commit"), "on");
  EXPECT_EQ(connection.execute("SELECT count(*) FROM pg_prepared_statements").integer(0, 0), 0);
  EXPECT_EQ(databases_.run("maps", "SELECT count(*) FROM pg_locks WHERE locktype = 'advisory'"), 0);
}

TEST_P(PostgresqlDatabaseTest, PassesValuesBitForBit) {
  PostgresqlConnection connection({.url = databases_.location("values")});
  const Blob blob = {0, 1, 255};
  const std::string text = "' \\ \xC3\xBC \" %";
  const std::vector<double> reals = {-0.0, std::numeric_limits<double>::denorm_min(), 0.1};
  const std::vector<std::uint64_t> numbers = {0, ~std::uint64_t{0}};
  const std::vector<BlobView> blobs = {blob, BlobView()};
  const PostgresqlRows rows = connection.execute(
      "SELECT $1, $2, $3, $4, $5, $6[1], $6[2], $6[3], $7[2], $8[1], $8[2], cardinality($9)",
      std::int64_t{-5}, true, std::optional<double>(), std::string_view(text), BlobView(blob),
      std::span<const double>(reals), std::span<const std::uint64_t>(numbers),
      std::span<const BlobView>(blobs), std::span<const double>());
  EXPECT_EQ(rows.integer(0, 0), -5);
  EXPECT_TRUE(rows.boolean(0, 1));
  EXPECT_TRUE(rows.is_null(0, 2));
  EXPECT_EQ(rows.text(0, 3), text);
  EXPECT_EQ(rows.copy(0, 4), blob);
  EXPECT_TRUE(std::signbit(rows.real(0, 5)));
  EXPECT_EQ(rows.real(0, 6), reals[1]);
  EXPECT_EQ(rows.real(0, 7), 0.1);
  EXPECT_EQ(rows.number(0, 8), numbers[1]);
  EXPECT_EQ(rows.copy(0, 9), blob);
  EXPECT_FALSE(rows.is_null(0, 10));
  EXPECT_EQ(rows.copy(0, 10), Blob());
}

}  // namespace
}  // namespace cornerfix::storage
