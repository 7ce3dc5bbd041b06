/// \file  A member of a request with its JSON pointer, so that each check can say where it failed.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <cornerfix/pose2.hpp>

#include "api/problem.hpp"

namespace cornerfix::api {

/// Any place on earth in any projection [m]; beyond, centimetres get lost in a double's digits.
inline constexpr double kMaxCoordinate = 1e8;

/// A turn, with room for rounding [rad].
inline constexpr double kMaxHeading = 6.3;

/// A view of a JSON value. The as_…() functions give the value, or nothing after adding to `errors`
/// what was expected. The value and the errors must outlive it.
class JsonField {
 public:
  JsonField(const nlohmann::json& value, std::string pointer, FieldErrors& errors)
      : value_(&value), pointer_(std::move(pointer)), errors_(&errors) {}

  [[nodiscard]] const nlohmann::json& json() const { return *value_; }
  [[nodiscard]] const std::string& pointer() const { return pointer_; }
  void fail(std::string detail) const { errors_->add(pointer_, std::move(detail)); }
  void fail_member(std::string_view name, std::string detail) const;
  /// `path` is a JSON pointer from here, without its first slash.
  void fail_path(const std::string& path, std::string detail) const;

  /// Adds an error when this is no object.
  [[nodiscard]] bool expect_object() const;
  /// Fails each member of an object that is not among these, so that nothing is ignored in silence.
  void expect_members(std::span<const std::string_view> known) const;
  void expect_members(std::initializer_list<std::string_view> known) const {
    expect_members(std::span(known.begin(), known.size()));
  }
  /// Of an object; nothing when it is absent or null.
  [[nodiscard]] std::optional<JsonField> find(std::string_view name) const;
  /// As find(), but adds an error when it is absent.
  [[nodiscard]] std::optional<JsonField> require(std::string_view name,
                                                 std::string_view meaning) const;
  /// Of an array.
  [[nodiscard]] JsonField item(std::size_t index) const;

  /// Finite, within [least, most].
  [[nodiscard]] std::optional<double> as_number(double least, double most) const;
  /// Seconds since any time: from -1e12 to 1e12, where doubles still resolve milliseconds.
  [[nodiscard]] std::optional<double> as_stamp() const;
  [[nodiscard]] std::optional<double> as_number() const;
  /// Radians within a turn: what is beyond is in degrees.
  [[nodiscard]] std::optional<double> as_heading() const;
  /// Whole, within [least, most]; 3.0 is whole.
  [[nodiscard]] std::optional<std::uint64_t> as_count(std::uint64_t least,
                                                      std::uint64_t most) const;
  [[nodiscard]] std::optional<std::string> as_text(std::size_t max_bytes) const;
  [[nodiscard]] std::optional<std::string> as_name() const;
  /// {"x", "y", "yaw"} in metres and radians; yaw is wrapped.
  [[nodiscard]] std::optional<Pose2> as_pose() const;

 private:
  const nlohmann::json* value_;
  std::string pointer_;
  FieldErrors* errors_;
};

}  // namespace cornerfix::api
