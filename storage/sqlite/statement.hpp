/// \file  Statements of the tables. They throw what SQLiteCpp throws: call them
/// under guarded().
#pragma once

#include <SQLiteCpp/Column.h>
#include <SQLiteCpp/Statement.h>

#include <cassert>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "storage/blob_codec.hpp"
#include "storage/sqlite/sqlite_database.hpp"

namespace cornerfix::storage {

/// A statement of the database's cache while it is in use. Two with the same text must not be in
/// use at once.
class Statement {
 public:
  Statement(SqliteDatabase& database, std::string_view sql) : statement_(database.prepared(sql)) {}
  /// An open cursor would keep the snapshot alive.
  ~Statement() { statement_.tryReset(); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  /// Sets all parameters, in order, for a new run. BLOBs must live until the statement has run.
  template <typename... Values>
  Statement& bind(const Values&... values) {
    assert(sizeof...(values) == static_cast<std::size_t>(statement_.getBindParameterCount()) &&
           "every parameter needs a value");
    statement_.reset();
    int index = 0;
    (set(++index, values), ...);
    return *this;
  }

  /// Goes to the next row; false when there is none.
  bool step() { return statement_.executeStep(); }
  /// For statements without rows; returns how many rows they changed.
  int run() { return statement_.exec(); }

  [[nodiscard]] bool is_null(int column) const { return statement_.getColumn(column).isNull(); }
  [[nodiscard]] std::int64_t integer(int column) const {
    return statement_.getColumn(column).getInt64();
  }
  [[nodiscard]] std::uint64_t number(int column) const {
    return static_cast<std::uint64_t>(integer(column));
  }
  [[nodiscard]] double real(int column) const { return statement_.getColumn(column).getDouble(); }
  [[nodiscard]] std::string text(int column) const {
    return statement_.getColumn(column).getString();
  }
  /// Valid until the next step.
  [[nodiscard]] BlobView blob(int column) const;

 private:
  void set(int index, std::int64_t value) { statement_.bind(index, value); }
  void set(int index, std::uint64_t value) {
    statement_.bind(index, static_cast<std::int64_t>(value));
  }
  void set(int index, double value) { statement_.bind(index, value); }
  void set(int index, std::optional<double> value) {
    value ? statement_.bind(index, *value) : statement_.bind(index);
  }
  void set(int index, std::string_view value) { statement_.bind(index, std::string(value)); }
  void set(int index, BlobView value);

  SQLite::Statement& statement_;
};

}  // namespace cornerfix::storage
