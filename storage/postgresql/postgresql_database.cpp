#include "storage/postgresql/postgresql_database.hpp"

#include <string>
#include <utility>

#include "storage/postgresql/postgresql_connection.hpp"
#include "storage/postgresql/postgresql_schema.hpp"
#include "storage/postgresql/postgresql_tables.hpp"

namespace cornerfix::storage {
namespace {

/// Where every change of a map or a token is counted, for other servers. Run last in a transaction,
/// since other writers of maps wait for this row.
constexpr const char* kCountChange = "UPDATE store_changes SET number = number + 1; ";

class PostgresqlTransaction : public Transaction {
 public:
  PostgresqlTransaction(PostgresqlConnection& connection, Access access, const bool& has_change)
      : connection_(connection), has_change_(has_change) {
    connection_.begin(access);
  }
  ~PostgresqlTransaction() override { connection_.roll_back(); }
  void commit() override { connection_.commit(has_change_ ? kCountChange : ""); }

 private:
  PostgresqlConnection& connection_;
  const bool& has_change_;
};

class PostgresqlDatabase : public Database {
 public:
  PostgresqlDatabase(PostgresqlTarget target, std::string location)
      : target_(std::move(target)), location_(std::move(location)), connection_(target_) {}

  Result<void> bring_up_to_date() {
    return guarded([&] { return migrate(connection_, postgresql_migrations()); });
  }

  Result<std::shared_ptr<Database>> open_another(Synchronous synchronous) const override {
    return guarded([&]() -> Result<std::shared_ptr<Database>> {
      PostgresqlTarget target = target_;
      target.synchronous = synchronous;
      return std::shared_ptr<Database>(
          std::make_shared<PostgresqlDatabase>(std::move(target), location_));
    });
  }

  const std::string& location() const override { return location_; }

  Result<std::int64_t> data_version() override {
    return guarded([&]() -> Result<std::int64_t> {
      return connection_.execute("SELECT number FROM store_changes").integer(0, 0);
    });
  }

  Result<void> probe() override {
    return guarded([&]() -> Result<void> {
      const std::int64_t found = stored_schema_version(connection_);
      if (found == postgresql_schema_version()) return {};
      return Error{ErrorCode::kUnavailable,
                   "the database has been migrated to schema " + std::to_string(found) +
                       ", this program writes " + std::to_string(postgresql_schema_version()),
                   location_};
    });
  }

  Result<std::uint64_t> used_bytes() override {
    return guarded([&]() -> Result<std::uint64_t> {
      return connection_.execute("SELECT pg_database_size(current_database())").number(0, 0);
    });
  }

  Result<void> probe_write() override {
    return guarded([&]() -> Result<void> {
      const auto transaction = begin(Access::kWrite);
      connection_.run_script("UPDATE store_changes SET number = number");
      connection_.commit();
      return {};
    });
  }

  /// The server answers for its own files, disk and pages.
  Result<void> check_in_place() const override { return {}; }
  Result<void> check_room(std::uint64_t) const override { return {}; }
  Result<void> check_pages(const std::atomic<bool>&) const override { return {}; }

  std::unique_ptr<Transaction> begin(Access access) override {
    has_change_ = false;
    return std::make_unique<PostgresqlTransaction>(connection_, access, has_change_);
  }
  MapTables& maps() override {
    has_change_ = true;
    return *maps_;
  }
  SessionTables& sessions() override { return *sessions_; }
  TokenTables& tokens() override {
    has_change_ = true;
    return *tokens_;
  }
  JobTables& jobs() override { return *jobs_; }

  LastIds last_ids() override {
    return {.map = last_of("SELECT CASE WHEN is_called THEN last_value ELSE 0 END "
                           "FROM maps_id_seq"),
            .session = last_of("SELECT CASE WHEN is_called THEN last_value ELSE 0 END "
                               "FROM sessions_number_seq"),
            .token = last_of("SELECT CASE WHEN is_called THEN last_value ELSE 0 END "
                             "FROM tokens_id_seq")};
  }

  void set_last_ids(const LastIds& ids) override {
    const auto set = [&](const char* sequence, std::int64_t id) {
      (void)connection_.execute("SELECT setval($1::regclass, greatest($2, 1), $2 > 0)",
                                std::string_view(sequence), id);
    };
    set("maps_id_seq", ids.map);
    set("sessions_number_seq", ids.session);
    set("tokens_id_seq", ids.token);
  }

 private:
  std::int64_t last_of(const char* sql) { return connection_.execute(sql).integer(0, 0); }

  PostgresqlTarget target_;
  std::string location_;
  PostgresqlConnection connection_;
  std::unique_ptr<MapTables> maps_ = make_map_tables(connection_);
  std::unique_ptr<SessionTables> sessions_ = make_session_tables(connection_);
  std::unique_ptr<TokenTables> tokens_ = make_token_tables(connection_);
  std::unique_ptr<JobTables> jobs_ = make_job_tables(connection_);
  /// Whether the current transaction may have changed what every server has in memory.
  bool has_change_ = false;
};

}  // namespace

Result<std::shared_ptr<Database>> open_postgresql(const std::string& url, Synchronous synchronous,
                                                  int busy_timeout_ms) {
  const Result<std::string> location = location_of(url);
  if (!location) return location.error();
  auto opened = guarded([&]() -> Result<std::shared_ptr<Database>> {
    auto database = std::make_shared<PostgresqlDatabase>(
        PostgresqlTarget{
            .url = url, .synchronous = synchronous, .busy_timeout_ms = busy_timeout_ms},
        *location);
    if (Result<void> done = database->bring_up_to_date(); !done) return done.error();
    return std::shared_ptr<Database>(std::move(database));
  });
  if (opened) return opened;
  Error error = opened.error();
  error.field = *location;
  return error;
}

}  // namespace cornerfix::storage
