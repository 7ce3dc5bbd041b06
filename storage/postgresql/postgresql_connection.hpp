/// \file  A connection to a PostgreSQL server that comes back after it was lost.
///
/// Keeps to what a pooler of transactions (PgBouncer) allows. Every setting is SET LOCAL, and every
/// lock ends with its transaction. No statement is prepared by name, and no table is temporary.
#pragma once

#include <libpq-fe.h>

#include <array>
#include <memory>
#include <span>
#include <string>

#include <cornerfix/result.hpp>

#include "storage/database.hpp"
#include "storage/postgresql/postgresql_values.hpp"

namespace cornerfix::storage {

/// Where a database is, and how long to wait for it.
struct PostgresqlTarget {
  std::string url;
  Synchronous synchronous = Synchronous::kFull;
  int busy_timeout_ms = kDefaultBusyTimeoutMs;
};

/// Where the database of a URL of libpq is, without its password. kInvalidArgument when it is no
/// such URL; the message does not repeat it.
[[nodiscard]] Result<std::string> location_of(const std::string& url);

/// Not synchronised. Functions throw StorageError: call them under guarded(). After a lost
/// connection the first call fails if it was inside a transaction. The next transaction, or the
/// next statement outside of one, connects anew.
class PostgresqlConnection {
 public:
  explicit PostgresqlConnection(const PostgresqlTarget& target);

  /// Runs one statement. Outside a transaction only those that change nothing.
  template <typename... Values>
  PostgresqlRows execute(const char* sql, const Values&... values) {
    const std::array<PostgresqlValue, sizeof...(Values)> parameters{value_of(values)...};
    return run(sql, parameters);
  }
  /// Runs statements without parameters, separated by semicolons, in the current transaction.
  void run_script(const std::string& sql);

  void begin(Access access);
  /// Runs `last`, statements that belong to the transaction, and commits in the same round trip.
  void commit(const std::string& last = "");
  void roll_back() noexcept;
  /// Whether the current transaction writes.
  [[nodiscard]] bool is_writing() const { return is_writing_; }

 private:
  PostgresqlRows run(const char* sql, std::span<const PostgresqlValue> parameters);
  PGresult* send(const char* sql, std::span<const PostgresqlValue> parameters);
  [[nodiscard]] bool is_lost(const PGresult* result) const;
  PostgresqlRows checked(PGresult* result);
  /// What `send` returns, for what may be sent twice.
  template <typename Send>
  PostgresqlRows retried(Send&& send);
  void connect_if_lost();

  std::string begin_reading_;
  std::string begin_writing_;
  std::unique_ptr<PGconn, decltype(&PQfinish)> connection_;
  bool is_in_transaction_ = false;
  bool is_writing_ = false;
  /// The server goes down or takes no writes: another one may have its address by now.
  bool is_retired_ = false;
};

}  // namespace cornerfix::storage
