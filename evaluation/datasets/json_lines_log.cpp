#include <simdjson.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "evaluation/datasets/scan_parser.hpp"

namespace cornerfix::evaluation {

namespace {

using simdjson::ondemand::object;
using simdjson::ondemand::value;

Error malformed_line(std::string message) {
  return {ErrorCode::kMalformed, std::move(message), ""};
}

bool is_blank(const std::string& line) {
  return line.find_first_not_of(" \t") == std::string::npos;
}

/// JSON has neither NaN nor infinity, but Python writes both.
bool is_not_finite(value number) {
  const std::string_view token = number.raw_json_token();
  return token.starts_with("NaN") || token.starts_with("Infinity") || token.starts_with("-Inf");
}

float range_or_nan(value range) {
  if (is_not_finite(range) || range.is_null()) return std::numeric_limits<float>::quiet_NaN();
  return static_cast<float>(range.get_double().value());
}

/// null is no limit.
double number_or_infinity(value number) {
  if (number.raw_json_token().starts_with("Infinity") || number.is_null())
    return std::numeric_limits<double>::infinity();
  return number.get_double();
}

/// What a member must be, for the message of an error.
std::string expected(std::string_view field) {
  if (field == "ranges") return "expected an array of metres or null";
  if (field == "odom" || field == "pose") return "expected [x, y, yaw] or null";
  if (field == "name" || field == "source") return "expected a text";
  return "expected a number";
}

/// As the HTTP API takes them [s].
constexpr double kLatestStamp = 1e12;

/// [x, y, yaw] or null.
std::optional<Pose2> pose_or_null(value pose) {
  if (pose.is_null()) return std::nullopt;
  std::array<double, 3> numbers{};
  std::size_t count = 0;
  for (auto number : pose.get_array()) {
    if (count == numbers.size()) throw simdjson::simdjson_error(simdjson::INCORRECT_TYPE);
    numbers[count++] = number.get_double();
  }
  if (count != numbers.size()) throw simdjson::simdjson_error(simdjson::INCORRECT_TYPE);
  return Pose2{numbers[0], numbers[1], wrap_angle(numbers[2])};
}

class JsonLinesParser final : public ScanParser {
 public:
  Result<std::optional<LogScan>> parse(const std::string& line) override {
    if (is_blank(line)) return std::optional<LogScan>();
    field_.clear();
    try {
      auto document =
          json_.iterate(simdjson::padded_string_view(line.data(), line.size(), line.capacity()));
      if (!has_header_) {
        header_ = {};
        named_beams_.reset();
        has_increment_ = false;
        read_header(document.get_object());
      } else {
        LogScan scan = read_scan(document.get_object());
        // Only at the end there is no location.
        if (!document.current_location().error())
          return malformed_line("more text behind the object");
        return check(std::move(scan));
      }
    } catch (const simdjson::simdjson_error& error) {
      if (error.error() == simdjson::INCORRECT_TYPE) {
        return malformed_line(field_.empty() ? "expected an object"
                                             : field_ + ": " + expected(field_));
      }
      return malformed_line((field_.empty() ? "" : field_ + ": ") + error.what());
    }
    if (!has_increment_) {
      return malformed_line(
          "header: expected name, beams, angle_min, angle_increment, range_min and range_max in "
          "front of the scans");
    }
    if (auto error = validate(header_.lidar)) {
      return malformed_line("header: " + error->field + " " + error->message);
    }
    if (header_.beams > LogReader::kMaxBeams)
      return malformed_line("header: beams " + too_many_beams());
    has_header_ = true;
    return std::optional<LogScan>();
  }

 private:
  void read_header(object fields) {
    for (auto field : fields) {
      field_ = std::string_view(field.unescaped_key());
      if (field_ == "name") {
        header_.name = std::string_view(field.value().get_string());
      } else if (field_ == "source") {
        header_.source = std::string_view(field.value().get_string());
      } else if (field_ == "time_increment") {
        time_increment_ = field.value().get_double();
      } else if (field_ == "beams") {
        header_.beams = field.value().get_uint64();
        named_beams_ = header_.beams;
      } else {
        has_increment_ |= field_ == "angle_increment";
        read_geometry(field.value(), header_.lidar);
      }
    }
    field_.clear();
  }

  /// The member named `field_`, if it is one of a lidar's geometry.
  void read_geometry(value member, LaserScan& lidar) const {
    if (field_ == "angle_min") {
      lidar.angle_min = member.get_double();
    } else if (field_ == "angle_increment") {
      lidar.angle_increment = member.get_double();
    } else if (field_ == "range_min") {
      lidar.range_min = member.get_double();
    } else if (field_ == "range_max") {
      lidar.range_max = number_or_infinity(member);
    }
  }

  LogScan read_scan(object fields) {
    LogScan out;
    out.scan = header_.lidar;
    out.time_increment = time_increment_;
    out.scan.ranges.reserve(header_.beams);
    has_stamp_ = false;
    has_own_angles_ = false;
    for (auto field : fields) {
      field_ = std::string_view(field.unescaped_key());
      if (field_ == "t") {
        out.scan.stamp = field.value().get_double();
        has_stamp_ = true;
      } else if (field_ == "ranges") {
        for (value range : field.value().get_array())
          out.scan.ranges.push_back(range_or_nan(range));
      } else if (field_ == "odom") {
        out.T_odom_laser = pose_or_null(field.value());
      } else if (field_ == "pose") {
        out.T_map_laser = pose_or_null(field.value());
      } else if (field_ == "kf") {
        out.is_key_scan = field.value().get_int64() != 0;
      } else if (field_ == "time_increment") {
        out.time_increment = field.value().get_double();
      } else {
        read_geometry(field.value(), out.scan);
        has_own_angles_ |= field_ == "angle_min" || field_ == "angle_increment";
      }
    }
    field_.clear();
    return out;
  }

  static std::string too_many_beams() { return "above " + std::to_string(LogReader::kMaxBeams); }

  Result<std::optional<LogScan>> check(LogScan scan) {
    if (!has_stamp_) return malformed_line("t: missing, expected seconds");
    if (!(std::abs(scan.scan.stamp) <= kLatestStamp)) {
      return malformed_line("t: expected seconds from -1e12 to 1e12");
    }
    if (scan.scan.ranges.empty()) return malformed_line("ranges: none, expected metres or null");
    if (scan.scan.ranges.size() > LogReader::kMaxBeams) {
      return malformed_line("ranges: number of values " + too_many_beams());
    }
    if (header_.beams == 0) header_.beams = scan.scan.ranges.size();
    if (named_beams_ && !has_own_angles_ && scan.scan.ranges.size() != *named_beams_) {
      return malformed_line("ranges: " + std::to_string(scan.scan.ranges.size()) +
                            " values, expected " + std::to_string(*named_beams_) +
                            " (from beams of the header)");
    }
    if (auto error = validate(scan.scan))
      return malformed_line(error->field + ": " + error->message);
    return std::optional<LogScan>(std::move(scan));
  }

  simdjson::ondemand::parser json_;
  bool has_header_ = false;
  bool has_stamp_ = false;
  bool has_increment_ = false;   ///< The header.
  bool has_own_angles_ = false;  ///< The scan being read.
  std::optional<std::size_t> named_beams_;
  double time_increment_ = 0.0;  ///< Of the header.
  std::string field_;            ///< Being read, for the message of an error.
};

}  // namespace

std::unique_ptr<ScanParser> make_json_lines_parser() { return std::make_unique<JsonLinesParser>(); }

}  // namespace cornerfix::evaluation
