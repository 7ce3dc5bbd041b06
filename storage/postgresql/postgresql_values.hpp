/// \file  Parameters and rows in PostgreSQL's binary formats, so that no number is rounded.
#pragma once

#include <libpq-fe.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "storage/blob_codec.hpp"

namespace cornerfix::storage {

/// One parameter of a statement. `view` is borrowed: it must live until the statement has run.
struct PostgresqlValue {
  Oid type = 0;
  bool is_null = false;
  std::string own{};        ///< Bytes of a number or an array.
  std::string_view view{};  ///< Bytes of a text or a BLOB.

  [[nodiscard]] std::string_view bytes() const { return own.empty() ? view : own; }
};

[[nodiscard]] PostgresqlValue value_of(std::int64_t value);
/// The same bits: PostgreSQL has no unsigned numbers.
[[nodiscard]] PostgresqlValue value_of(std::uint64_t value);
[[nodiscard]] PostgresqlValue value_of(bool value);
[[nodiscard]] PostgresqlValue value_of(std::optional<double> value);
[[nodiscard]] PostgresqlValue value_of(std::string_view value);
[[nodiscard]] PostgresqlValue value_of(BlobView value);
/// Arrays of one dimension.
[[nodiscard]] PostgresqlValue value_of(std::span<const double> values);
[[nodiscard]] PostgresqlValue value_of(std::span<const std::uint64_t> values);
[[nodiscard]] PostgresqlValue value_of(std::span<const std::int64_t> values);
[[nodiscard]] PostgresqlValue value_of(std::span<const BlobView> values);
[[nodiscard]] PostgresqlValue value_of(std::span<const std::string_view> values);
template <typename T>
[[nodiscard]] PostgresqlValue value_of(const std::vector<T>& values) {
  return value_of(std::span<const T>(values));
}

/// What a statement returned. Views of it live as long as it does.
class PostgresqlRows {
 public:
  explicit PostgresqlRows(PGresult* result) : result_(result, &PQclear) {}

  [[nodiscard]] int size() const { return PQntuples(result_.get()); }
  [[nodiscard]] bool empty() const { return size() == 0; }
  /// How many rows the statement has changed.
  [[nodiscard]] std::size_t changed() const;

  [[nodiscard]] bool is_null(int row, int column) const {
    return PQgetisnull(result_.get(), row, column) == 1;
  }
  [[nodiscard]] std::int64_t integer(int row, int column) const;  ///< bigint.
  [[nodiscard]] std::uint64_t number(int row, int column) const {
    return static_cast<std::uint64_t>(integer(row, column));
  }
  [[nodiscard]] bool boolean(int row, int column) const;
  [[nodiscard]] double real(int row, int column) const;  ///< double precision.
  [[nodiscard]] std::string text(int row, int column) const;
  [[nodiscard]] BlobView blob(int row, int column) const;
  [[nodiscard]] Blob copy(int row, int column) const;

 private:
  std::unique_ptr<PGresult, decltype(&PQclear)> result_;
};

}  // namespace cornerfix::storage
