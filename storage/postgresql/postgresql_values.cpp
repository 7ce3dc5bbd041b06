#include "storage/postgresql/postgresql_values.hpp"

#include <bit>
#include <cassert>
#include <charconv>
#include <concepts>

namespace cornerfix::storage {
namespace {

// Types of PostgreSQL (its catalog pg_type), which never change.
constexpr Oid kBool = 16;
constexpr Oid kBytea = 17;
constexpr Oid kInt8 = 20;
constexpr Oid kText = 25;
constexpr Oid kFloat8 = 701;
constexpr Oid kInt8Array = 1016;
constexpr Oid kFloat8Array = 1022;
constexpr Oid kByteaArray = 1001;
constexpr Oid kTextArray = 1009;

template <std::unsigned_integral T>
void append_big_endian(std::string& bytes, T value) {
  for (int shift = (static_cast<int>(sizeof(T)) - 1) * 8; shift >= 0; shift -= 8)
    bytes += static_cast<char>(value >> static_cast<unsigned>(shift) & 0xFFU);
}

std::string big_endian(std::uint64_t value) {
  std::string bytes;
  append_big_endian(bytes, value);
  return bytes;
}

std::string_view characters(BlobView blob) {
  return {reinterpret_cast<const char*>(blob.data()), blob.size()};
}

/// The head of an array of one dimension (PostgreSQL's array_recv).
std::string array_head(Oid element, std::size_t size) {
  std::string bytes;
  append_big_endian(bytes, std::uint32_t{size > 0 ? 1U : 0U});  // Dimensions.
  append_big_endian(bytes, std::uint32_t{0});                   // No element is NULL.
  append_big_endian(bytes, static_cast<std::uint32_t>(element));
  if (size == 0) return bytes;
  append_big_endian(bytes, static_cast<std::uint32_t>(size));
  append_big_endian(bytes, std::uint32_t{1});  // The first index.
  return bytes;
}

template <typename T>
PostgresqlValue array_of_numbers(Oid array, Oid element, std::span<const T> values) {
  PostgresqlValue value{.type = array, .own = array_head(element, values.size())};
  for (const T number : values) {
    append_big_endian(value.own, std::uint32_t{sizeof(T)});
    append_big_endian(value.own, std::bit_cast<std::uint64_t>(number));
  }
  return value;
}

std::string_view characters(std::string_view text) { return text; }

template <typename T>
PostgresqlValue array_of_strings(Oid array, Oid element, std::span<const T> values) {
  PostgresqlValue value{.type = array, .own = array_head(element, values.size())};
  for (const T each : values) {
    append_big_endian(value.own, static_cast<std::uint32_t>(each.size()));
    value.own += characters(each);
  }
  return value;
}

}  // namespace

PostgresqlValue value_of(std::int64_t value) {
  return {.type = kInt8, .own = big_endian(static_cast<std::uint64_t>(value))};
}

PostgresqlValue value_of(std::uint64_t value) { return {.type = kInt8, .own = big_endian(value)}; }

PostgresqlValue value_of(bool value) {
  return {.type = kBool, .own = std::string(1, value ? '\1' : '\0')};
}

PostgresqlValue value_of(std::optional<double> value) {
  if (!value) return {.type = kFloat8, .is_null = true};
  return {.type = kFloat8, .own = big_endian(std::bit_cast<std::uint64_t>(*value))};
}

PostgresqlValue value_of(std::string_view value) { return {.type = kText, .view = value}; }

PostgresqlValue value_of(BlobView value) { return {.type = kBytea, .view = characters(value)}; }

PostgresqlValue value_of(std::span<const double> values) {
  return array_of_numbers(kFloat8Array, kFloat8, values);
}

PostgresqlValue value_of(std::span<const std::uint64_t> values) {
  return array_of_numbers(kInt8Array, kInt8, values);
}

PostgresqlValue value_of(std::span<const std::int64_t> values) {
  return array_of_numbers(kInt8Array, kInt8, values);
}

PostgresqlValue value_of(std::span<const BlobView> values) {
  return array_of_strings(kByteaArray, kBytea, values);
}

PostgresqlValue value_of(std::span<const std::string_view> values) {
  return array_of_strings(kTextArray, kText, values);
}

std::size_t PostgresqlRows::changed() const {
  const std::string_view count = PQcmdTuples(result_.get());
  std::size_t changed = 0;
  std::from_chars(count.data(), count.data() + count.size(), changed);
  return changed;
}

BlobView PostgresqlRows::blob(int row, int column) const {
  return {reinterpret_cast<const std::uint8_t*>(PQgetvalue(result_.get(), row, column)),
          static_cast<std::size_t>(PQgetlength(result_.get(), row, column))};
}

Blob PostgresqlRows::copy(int row, int column) const {
  const BlobView view = blob(row, column);
  return {view.begin(), view.end()};
}

std::string PostgresqlRows::text(int row, int column) const {
  return std::string(characters(blob(row, column)));
}

std::int64_t PostgresqlRows::integer(int row, int column) const {
  const BlobView bytes = blob(row, column);
  assert(bytes.size() == sizeof(std::int64_t) && "a column of bigint");
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8U | byte;
  return static_cast<std::int64_t>(value);
}

bool PostgresqlRows::boolean(int row, int column) const {
  const BlobView bytes = blob(row, column);
  assert(bytes.size() == 1 && "a column of boolean");
  return bytes[0] != 0;
}

double PostgresqlRows::real(int row, int column) const {
  return std::bit_cast<double>(number(row, column));
}

}  // namespace cornerfix::storage
