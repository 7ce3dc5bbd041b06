#include "storage/postgresql/postgresql_connection.hpp"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

namespace cornerfix::storage {
namespace {

using Options = std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)>;

/// What a URL does not say. A lost network is noticed after seconds, not after two hours.
constexpr std::array<std::pair<const char*, const char*>, 6> kDefaults = {{
    {"connect_timeout", "5"},
    {"tcp_user_timeout", "5000"},
    {"keepalives_idle", "5"},
    {"keepalives_interval", "2"},
    {"keepalives_count", "3"},
    {"application_name", "cornerfix"},
}};

/// A replica that was cut off within a transaction holds its locks no longer than this. A robot
/// waits for that of its session, so it ends before a proxy has found another replica.
constexpr int kMaxPauseInTransactionMs = 10'000;
constexpr int kMaxPauseOfSessionsMs = 2'000;

Options parse(const std::string& url) {
  return {PQconninfoParse(url.c_str(), nullptr), &PQconninfoFree};
}

std::string option(const Options& options, std::string_view keyword) {
  for (const PQconninfoOption* entry = options.get(); entry != nullptr && entry->keyword != nullptr;
       ++entry) {
    if (entry->keyword == keyword) return entry->val == nullptr ? "" : entry->val;
  }
  return "";
}

/// Removes the line feed at the end of libpq's messages, and those within.
std::string one_line(std::string message) {
  while (!message.empty() && message.back() == '\n') message.pop_back();
  std::ranges::replace(message, '\n', ' ');
  return message;
}

ErrorCode code_of_state(std::string_view state) {
  if (state == "23505") return ErrorCode::kConflict;                      // unique_violation
  if (state == "40001" || state == "40P01") return ErrorCode::kConflict;  // other transaction won
  if (state == "53100") return ErrorCode::kStorageFull;                   // disk_full
  if (state.starts_with("XX0") && state != "XX000") return ErrorCode::kCorruptData;
  if (state.starts_with("54")) return ErrorCode::kTooLarge;  // program_limit_exceeded
  if (state == "22021") return ErrorCode::kInvalidArgument;  // not UTF-8
  // Lost connections, missing resources, lock time-outs, servers that go down, I/O errors, a
  // standby that takes no writes, missing rights.
  for (const std::string_view known : {"08", "53", "55P03", "57", "58", "25006", "42501", "28"})
    if (state.starts_with(known)) return ErrorCode::kUnavailable;
  return ErrorCode::kInternal;
}

std::string_view state_of(const PGresult* result) {
  const char* field = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  return field == nullptr ? "" : field;
}

/// Whether the server will answer no later transaction as it should.
bool is_last_word(std::string_view state) { return state == "25006" || state.starts_with("57P"); }

}  // namespace

Result<std::string> location_of(const std::string& url) {
  const Options options = parse(url);
  if (!options) {
    return Error{ErrorCode::kInvalidArgument,
                 "expected a URL such as postgresql://user:password@host:5432/database",
                 "postgresql://"};
  }
  std::string location = "postgresql://";
  if (const std::string user = option(options, "user"); !user.empty()) location += user + "@";
  location += option(options, "host");
  if (const std::string port = option(options, "port"); !port.empty()) location += ":" + port;
  return location + "/" + option(options, "dbname");
}

PostgresqlConnection::PostgresqlConnection(const PostgresqlTarget& target)
    : connection_(nullptr, &PQfinish) {
  const bool is_for_sessions = target.synchronous == Synchronous::kNormal;
  begin_reading_ = "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY";
  begin_writing_ =
      "BEGIN ISOLATION LEVEL READ COMMITTED READ WRITE; SET LOCAL lock_timeout = " +
      std::to_string(std::max(1, target.busy_timeout_ms)) +
      "; SET LOCAL idle_in_transaction_session_timeout = " +
      std::to_string(is_for_sessions ? kMaxPauseOfSessionsMs : kMaxPauseInTransactionMs);
  if (is_for_sessions) begin_writing_ += "; SET LOCAL synchronous_commit = off";
  const Options options = parse(target.url);
  // A URL in "dbname" is expanded; what stands after it has precedence.
  std::vector<const char*> keywords = {"dbname", "client_encoding"};
  std::vector<const char*> values = {target.url.c_str(), "UTF8"};
  for (const auto& [keyword, value] : kDefaults) {
    if (!option(options, keyword).empty()) continue;
    keywords.push_back(keyword);
    values.push_back(value);
  }
  keywords.push_back(nullptr);
  values.push_back(nullptr);
  connection_.reset(PQconnectdbParams(keywords.data(), values.data(), 1));
  PQsetNoticeReceiver(
      connection_.get(), [](void*, const PGresult*) {}, nullptr);
  connect_if_lost();
}

void PostgresqlConnection::connect_if_lost() {
  const bool is_usable = PQstatus(connection_.get()) == CONNECTION_OK && !is_retired_ &&
                         PQtransactionStatus(connection_.get()) == PQTRANS_IDLE;
  if (is_usable) return;
  PQreset(connection_.get());
  is_retired_ = false;
  if (PQstatus(connection_.get()) == CONNECTION_OK) return;
  throw StorageError(
      {ErrorCode::kUnavailable, "database: " + one_line(PQerrorMessage(connection_.get())), ""});
}

PGresult* PostgresqlConnection::send(const char* sql, std::span<const PostgresqlValue> parameters) {
  constexpr int kBinary = 1;
  std::vector<Oid> types;
  std::vector<const char*> values;
  std::vector<int> lengths;
  for (const PostgresqlValue& parameter : parameters) {
    const std::string_view bytes = parameter.bytes();
    types.push_back(parameter.type);
    // An empty view may have no address, which would mean NULL.
    values.push_back(parameter.is_null ? nullptr : (bytes.empty() ? "" : bytes.data()));
    lengths.push_back(static_cast<int>(bytes.size()));
  }
  const std::vector<int> formats(parameters.size(), kBinary);
  return PQexecParams(connection_.get(), sql, static_cast<int>(parameters.size()), types.data(),
                      values.data(), lengths.data(), formats.data(), kBinary);
}

bool PostgresqlConnection::is_lost(const PGresult* result) const {
  if (PQstatus(connection_.get()) != CONNECTION_OK) return true;
  const ExecStatusType status = PQresultStatus(result);
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return false;
  const std::string_view state = state_of(result);
  return state.empty() || is_last_word(state);  // libpq's own errors have no SQLSTATE.
}

PostgresqlRows PostgresqlConnection::checked(PGresult* result) {
  PostgresqlRows rows(result);
  if (is_lost(result)) {
    is_retired_ = true;
    throw StorageError({ErrorCode::kUnavailable,
                        "database: the connection to PostgreSQL was lost: " +
                            one_line(PQerrorMessage(connection_.get())),
                        ""});
  }
  const ExecStatusType status = PQresultStatus(result);
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return rows;
  const std::string state(state_of(result));
  const char* message = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  throw StorageError({code_of_state(state),
                      "database: " + std::string(message == nullptr ? "no answer" : message) +
                          " (SQLSTATE " + state + ")",
                      ""});
}

template <typename Send>
PostgresqlRows PostgresqlConnection::retried(Send&& send) {
  connect_if_lost();
  PGresult* result = send();
  if (!is_lost(result)) return checked(result);
  // The server had closed the connection while it was not used: nothing was done yet.
  PQclear(result);
  is_retired_ = true;
  connect_if_lost();
  return checked(send());
}

PostgresqlRows PostgresqlConnection::run(const char* sql,
                                         std::span<const PostgresqlValue> parameters) {
  if (is_in_transaction_) return checked(send(sql, parameters));
  return retried([&] { return send(sql, parameters); });
}

void PostgresqlConnection::run_script(const std::string& sql) {
  (void)checked(PQexec(connection_.get(), sql.c_str()));
}

void PostgresqlConnection::begin(Access access) {
  const std::string& sql = access == Access::kWrite ? begin_writing_ : begin_reading_;
  (void)retried([&] { return PQexec(connection_.get(), sql.c_str()); });
  is_in_transaction_ = true;
  is_writing_ = access == Access::kWrite;
}

void PostgresqlConnection::commit(const std::string& last) {
  run_script(last + "COMMIT");
  is_in_transaction_ = false;
  is_writing_ = false;
}

void PostgresqlConnection::roll_back() noexcept {
  if (!is_in_transaction_) return;
  is_in_transaction_ = false;
  is_writing_ = false;
  // Where this fails, the transaction status makes the next call connect anew.
  if (PQstatus(connection_.get()) == CONNECTION_OK) PQclear(PQexec(connection_.get(), "ROLLBACK"));
}

}  // namespace cornerfix::storage
