/// \file  What can fail returns a `Result`: a value, or an `Error` that says what, where and what
/// was expected.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace cornerfix {

enum class ErrorCode {
  kInvalidArgument,  ///< Well-formed but wrong: a value outside its limits.
  kMalformed,        ///< Cannot be read at all: broken JSON, a truncated image.
  kNotFound,
  kConflict,     ///< The state does not allow it now: a wrong sequence, a deleted map.
  kTooLarge,     ///< Above a configured limit.
  kCorruptData,  ///< Stored data that does not pass its checks.
  kUnavailable,  ///< May work later: busy, shutting down.
  kStorageFull,
  kInternal,
};

/// Why something could not be done, for a person to read.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;  ///< What was wrong and what was expected.
  std::string field;    ///< Where: a JSON pointer, a parameter's name or a path; may be empty.
};

/// A value or the reason why there is none. Same thread safety as its value.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value)
      : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT: implicit by design
  Result(Error error)
      : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: implicit by design

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & { return assert(ok()), std::get<0>(state_); }
  const T& value() const& { return assert(ok()), std::get<0>(state_); }
  T&& value() && { return assert(ok()), std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  [[nodiscard]] const Error& error() const { return assert(!ok()), std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

/// Success without a value, or an `Error`.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT: implicit by design

  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const { return assert(!ok()), *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace cornerfix
