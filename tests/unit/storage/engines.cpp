#include "unit/storage/engines.hpp"

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdlib>
#include <stdexcept>

#ifdef CORNERFIX_HAS_POSTGRESQL
#include <libpq-fe.h>

#include "support/postgresql_server.hpp"
#endif

namespace cornerfix::storage {
namespace {

std::string hex_of(BlobView blob) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  for (const std::uint8_t byte : blob) {
    hex += kDigits[byte >> 4U];
    hex += kDigits[byte & 0xFU];
  }
  return hex;
}

std::int64_t run_on_file(const std::string& file, const std::string& sql) {
  SQLite::Database connection(file, SQLite::OPEN_READWRITE);
  connection.exec("PRAGMA foreign_keys = ON");
  SQLite::Statement statement(connection, sql);
  return statement.executeStep() ? statement.getColumn(0).getInt64() : 0;
}

#ifdef CORNERFIX_HAS_POSTGRESQL
std::int64_t run_on_server(const std::string& url, const std::string& sql) {
  const std::unique_ptr<PGconn, decltype(&PQfinish)> connection(PQconnectdb(url.c_str()),
                                                                &PQfinish);
  const std::unique_ptr<PGresult, decltype(&PQclear)> result(PQexec(connection.get(), sql.c_str()),
                                                             &PQclear);
  const ExecStatusType status = PQresultStatus(result.get());
  if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK)
    throw std::runtime_error(PQerrorMessage(connection.get()));
  return PQntuples(result.get()) > 0 ? std::atoll(PQgetvalue(result.get(), 0, 0)) : 0;
}

testing::PostgresqlServer& server() { return testing::PostgresqlServer::shared(); }
#endif

}  // namespace

std::vector<Engine> engines() {
#ifdef CORNERFIX_HAS_POSTGRESQL
  return {Engine::kSqlite, Engine::kPostgresql};
#else
  return {Engine::kSqlite};
#endif
}

std::string name_of(Engine engine) { return engine == Engine::kSqlite ? "Sqlite" : "Postgresql"; }

TestDatabases::TestDatabases(Engine engine) : engine_(engine) {
#ifdef CORNERFIX_HAS_POSTGRESQL
  if (engine_ == Engine::kSqlite) return;
  static int tests = 0;
  prefix_ = "test" + std::to_string(++tests) + "_";
  if (!server().is_installed()) {
    obstacle_ = "PostgreSQL is not installed";
  } else if (!server().is_running()) {
    obstacle_ = "PostgreSQL did not start";
  }
#endif
}

std::string TestDatabases::location(const std::string& name) {
#ifdef CORNERFIX_HAS_POSTGRESQL
  if (engine_ == Engine::kPostgresql) {
    // A schema is a database of its own to Cornerfix, and is made in a hundredth of the time.
    const std::string schema = prefix_ + name;
    const std::string url = server().url("postgres");
    if (created_.insert(name).second) run_on_server(url, "CREATE SCHEMA " + schema);
    return url + "&options=-csearch_path%3D" + schema;
  }
#endif
  return (directory_ / (name + ".db")).string();
}

Result<std::shared_ptr<Database>> TestDatabases::try_open(const std::string& name,
                                                          int busy_timeout_ms) {
  return Database::open(location(name), Synchronous::kFull, busy_timeout_ms);
}

std::shared_ptr<Database> TestDatabases::open(const std::string& name, Synchronous synchronous) {
  if (!obstacle_.empty()) return nullptr;
  auto database = Database::open(location(name), synchronous);
  if (!database) throw std::runtime_error(database.error().message);
  return *database;
}

std::int64_t TestDatabases::run(const std::string& name, const std::string& sql) {
#ifdef CORNERFIX_HAS_POSTGRESQL
  if (engine_ == Engine::kPostgresql) return run_on_server(location(name), sql);
#endif
  return run_on_file(location(name), sql);
}

std::string TestDatabases::literal(BlobView blob) const {
  return engine_ == Engine::kSqlite ? "X'" + hex_of(blob) + "'" : "'\\x" + hex_of(blob) + "'";
}

void EngineTest::SetUp() {
  if (databases_.obstacle().empty()) return;
  if (std::getenv("CORNERFIX_REQUIRE_TOOLS") != nullptr) FAIL() << databases_.obstacle();
  GTEST_SKIP() << databases_.obstacle();
}

}  // namespace cornerfix::storage
