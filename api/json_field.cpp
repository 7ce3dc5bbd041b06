#include "api/json_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "api/requests.hpp"

namespace cornerfix::api {
namespace {

/// RFC 6901, section 3.
std::string escape(std::string_view name) {
  std::string escaped;
  for (const char c : name) {
    if (c == '~') {
      escaped += "~0";
    } else if (c == '/') {
      escaped += "~1";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string as_text_of(double value) { return nlohmann::json(value).dump(); }

}  // namespace

void JsonField::fail_member(std::string_view name, std::string detail) const {
  fail_path(escape(name), std::move(detail));
}

void JsonField::fail_path(const std::string& path, std::string detail) const {
  errors_->add(pointer_ + "/" + path, std::move(detail));
}

bool JsonField::expect_object() const {
  if (!value_->is_object()) fail("must be an object");
  return value_->is_object();
}

void JsonField::expect_members(std::span<const std::string_view> known) const {
  std::string names;
  for (const std::string_view name : known)
    names += (names.empty() ? "" : ", ") + std::string(name);
  for (const auto& [name, value] : value_->items()) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      fail_member(name, "is not known here; known are " + names);
    }
  }
}

std::optional<JsonField> JsonField::find(std::string_view name) const {
  const auto member = value_->find(name);
  if (member == value_->end() || member->is_null()) return std::nullopt;
  return JsonField(*member, pointer_ + "/" + escape(name), *errors_);
}

std::optional<JsonField> JsonField::require(std::string_view name, std::string_view meaning) const {
  auto member = find(name);
  if (!member) fail_member(name, "is needed: " + std::string(meaning));
  return member;
}

JsonField JsonField::item(std::size_t index) const {
  return {(*value_)[index], pointer_ + "/" + std::to_string(index), *errors_};
}

std::optional<double> JsonField::as_number(double least, double most) const {
  const double number =
      value_->is_number() ? value_->get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (number >= least && number <= most) return number;
  fail("must be a number from " + as_text_of(least) + " to " + as_text_of(most));
  return std::nullopt;
}

std::optional<double> JsonField::as_stamp() const {
  constexpr double kMaxStamp = 1e12;
  const double stamp =
      value_->is_number() ? value_->get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (std::abs(stamp) <= kMaxStamp) return stamp;
  fail(std::string("must be a number of seconds from -1e12 to 1e12") +
       (std::isnan(stamp) ? "" : ": are these milli- or nanoseconds?"));
  return std::nullopt;
}

std::optional<double> JsonField::as_heading() const {
  const auto heading = as_number();
  if (!heading || std::abs(*heading) <= kMaxHeading) return heading;
  fail("must be radians within a turn, not " + as_text_of(*heading) + ": are these degrees?");
  return std::nullopt;
}

std::optional<double> JsonField::as_number() const {
  const double number =
      value_->is_number() ? value_->get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (std::isfinite(number)) return number;
  fail("must be a finite number");
  return std::nullopt;
}

std::optional<std::uint64_t> JsonField::as_count(std::uint64_t least, std::uint64_t most) const {
  constexpr double kLargestExact = 9007199254740992.0;  // 2^53
  std::optional<std::uint64_t> count;
  if (value_->is_number_unsigned()) {
    count = value_->get<std::uint64_t>();
  } else if (value_->is_number()) {
    const double number = value_->get<double>();
    const bool whole = number >= 0.0 && number <= kLargestExact && number == std::floor(number);
    if (whole) count = static_cast<std::uint64_t>(number);
  }
  if (count && *count >= least && *count <= most) return count;
  fail("must be a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  return std::nullopt;
}

std::optional<std::string> JsonField::as_text(std::size_t max_bytes) const {
  if (value_->is_string() && value_->get_ref<const std::string&>().size() <= max_bytes) {
    return value_->get<std::string>();
  }
  fail("must be a text of at most " + std::to_string(max_bytes) + " bytes");
  return std::nullopt;
}

std::optional<std::string> JsonField::as_name() const {
  if (value_->is_string() && is_valid_name(value_->get_ref<const std::string&>())) {
    return value_->get<std::string>();
  }
  fail("must be a name: [A-Za-z0-9][A-Za-z0-9._-]{0,127}");
  return std::nullopt;
}

std::optional<Pose2> JsonField::as_pose() const {
  if (!expect_object()) return std::nullopt;
  const auto x_field = require("x", "metres");
  const auto y_field = require("y", "metres");
  const auto yaw_field = require("yaw", "radians");
  const auto x = x_field ? x_field->as_number(-kMaxCoordinate, kMaxCoordinate) : std::nullopt;
  const auto y = y_field ? y_field->as_number(-kMaxCoordinate, kMaxCoordinate) : std::nullopt;
  const auto yaw = yaw_field ? yaw_field->as_number() : std::nullopt;
  if (!x || !y || !yaw) return std::nullopt;
  return Pose2{*x, *y, wrap_angle(*yaw)};
}

}  // namespace cornerfix::api
