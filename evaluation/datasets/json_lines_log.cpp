#include <simdjson.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "evaluation/datasets/lidar_choice.hpp"
#include "evaluation/datasets/scan_limits.hpp"
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

/// Whether `token` is this number that JSON does not have. Python writes NaN and Infinity, C++ nan
/// and inf, and Protobuf puts both in quotes.
bool is_unusual_number(std::string_view token, std::string_view lower_case_name) {
  if (token.starts_with('"')) token.remove_prefix(1);
  if (token.starts_with('-') || token.starts_with('+')) token.remove_prefix(1);
  const auto is_same_letter = [](char letter, char lower) { return (letter | 0x20) == lower; };
  return token.size() >= lower_case_name.size() &&
         std::equal(lower_case_name.begin(), lower_case_name.end(), token.begin(),
                    [&](char lower, char letter) { return is_same_letter(letter, lower); });
}

/// NaN for what is null, or a number that JSON does not have.
double number_or_nan(value number) {
  const std::string_view token = number.raw_json_token();
  if (is_unusual_number(token, "nan") || is_unusual_number(token, "inf") || number.is_null()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return number.get_double();
}

/// null is no limit.
double number_or_infinity(value number) {
  if (is_unusual_number(number.raw_json_token(), "inf") || number.is_null())
    return std::numeric_limits<double>::infinity();
  return number.get_double();
}

/// What a member must be, for the message of an error.
std::string expected(std::string_view field) {
  if (field == "ranges") return "expected an array of metres or null";
  if (field.starts_with("ranges/")) return "expected metres or null";
  if (field == "odom" || field == "pose") return "expected [x, y, yaw] or null";
  if (field == "name" || field == "source" || field == "lidar") return "expected a text";
  return "expected a number";
}

/// A member that is there twice: which is right is not known.
struct RepeatedMember {};

std::string without_period(std::string message) {
  if (message.ends_with('.')) message.pop_back();
  return message;
}

constexpr const char* kOneObjectPerLine = "expected one object per line, ended by LF";

/// [x, y, yaw] or null; nothing where one of them is NaN.
std::optional<Pose2> pose_or_null(value pose) {
  if (pose.is_null()) return std::nullopt;
  std::array<double, 3> numbers{};
  std::size_t count = 0;
  for (value number : pose.get_array()) {
    if (count == numbers.size()) throw simdjson::simdjson_error(simdjson::INCORRECT_TYPE);
    numbers[count++] = number_or_nan(number);
  }
  if (count != numbers.size()) throw simdjson::simdjson_error(simdjson::INCORRECT_TYPE);
  if (std::ranges::any_of(numbers, [](double number) { return std::isnan(number); })) {
    return std::nullopt;
  }
  return Pose2{numbers[0], numbers[1], wrap_angle(numbers[2])};
}

class JsonLinesParser final : public ScanParser {
 public:
  explicit JsonLinesParser(std::string lidar)
      : lidars_(lidar.empty() ? std::nullopt : std::optional(std::move(lidar))) {}

  Result<std::optional<LogScan>> parse(const std::string& line) override {
    if (is_blank(line)) return std::optional<LogScan>();
    field_.clear();
    try {
      auto document =
          json_.iterate(simdjson::padded_string_view(line.data(), line.size(), line.capacity()));
      std::optional<LogScan> scan;
      if (has_header_) {
        scan = read_scan(document.get_object());
      } else {
        header_ = {};
        named_beams_.reset();
        time_increment_ = 0.0;
        read_header(document.get_object());
      }
      // Only at the end there is no location.
      if (!document.current_location().error()) {
        return malformed_line("more text behind the object, " + std::string(kOneObjectPerLine));
      }
      if (scan && is_header(*scan)) {
        has_header_ = false;
        return parse(line);
      }
      if (scan) unread_.merge(unread_of_line_);
      if (scan) return lidars_.is_wanted(lidar_) ? check(std::move(*scan)) : nothing();
    } catch (const RepeatedMember&) {
      return malformed_line(field_ + ": there twice, expected once");
    } catch (const simdjson::simdjson_error& error) {
      if (error.error() == simdjson::INCORRECT_TYPE) {
        return malformed_line(field_.empty() ? std::string(kOneObjectPerLine)
                                             : field_ + ": " + expected(field_));
      }
      if (field_.empty())
        return malformed_line(without_period(error.what()) + "; " + kOneObjectPerLine);
      return malformed_line(field_ + ": " + error.what());
    }
    if (const std::string missing = missing_geometry(); !missing.empty()) {
      return malformed_line("header: without " + missing +
                            ", expected name, beams, angle_min, angle_increment, range_min and "
                            "range_max in front of the scans");
    }
    if (auto error = validate(header_.lidar)) {
      return malformed_line("header: " + error->field + " " + error->message);
    }
    if (header_.beams > LogReader::kMaxBeams)
      return malformed_line("header: beams " + too_many_beams());
    has_header_ = true;
    return members_.contains("ranges") ? parse(line) : nothing();
  }

  [[nodiscard]] std::string contents() const override { return lidars_.contents(); }
  [[nodiscard]] std::string assumption() const override {
    if (unread_.empty()) return "";
    std::string names;
    for (const std::string& name : unread_) names += (names.empty() ? "" : ", ") + name;
    return "members of scans that are not read: " + names +
           "; read are t, ranges, odom, pose, lidar, kf, time_increment, angle_min, "
           "angle_increment, range_min and range_max";
  }
  [[nodiscard]] std::string choice() const override { return lidars_.choice(); }

 private:
  static constexpr std::size_t kLongestName = 40;

  static Result<std::optional<LogScan>> nothing() { return std::optional<LogScan>(); }

  /// Whether the line read as a scan begins another log behind the first one.
  [[nodiscard]] bool is_header(const LogScan& scan) const {
    return !has_stamp_ && !members_.contains("ranges") && scan.scan.ranges.empty() &&
           missing_geometry().empty();
  }

  /// What the header, or a scan in its place, does not have.
  [[nodiscard]] std::string missing_geometry() const {
    std::string names;
    for (const char* name : {"angle_min", "angle_increment", "range_max"}) {
      if (!members_.contains(name)) names += (names.empty() ? "" : ", ") + std::string(name);
    }
    return names;
  }

  /// Goes on to the next member of an object.
  void begin_member(std::string_view name) {
    field_ = name;
    if (!members_.insert(field_).second) throw RepeatedMember();
  }

  void read_header(object fields) {
    members_.clear();
    for (auto field : fields) {
      begin_member(field.unescaped_key());
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
        read_geometry(field.value(), header_.lidar);
      }
    }
    field_.clear();
  }

  /// Reads the member named `field_`. False if it is none of a lidar's geometry.
  bool read_geometry(value member, LaserScan& lidar) const {
    if (field_ == "angle_min") {
      lidar.angle_min = member.get_double();
    } else if (field_ == "angle_increment") {
      lidar.angle_increment = member.get_double();
    } else if (field_ == "range_min") {
      lidar.range_min = member.get_double();
    } else if (field_ == "range_max") {
      lidar.range_max = number_or_infinity(member);
    } else {
      return false;
    }
    return true;
  }

  /// Of a scan. Those of a LaserScan that are never used are passed over.
  void note_unread_member() {
    constexpr std::size_t kMostNames = 10;
    constexpr std::array<std::string_view, 3> kUnused = {"angle_max", "scan_time", "intensities"};
    if (std::ranges::find(kUnused, field_) != kUnused.end()) return;
    if (unread_.size() + unread_of_line_.size() < kMostNames)
      unread_of_line_.insert(field_.substr(0, kLongestName));
  }

  LogScan read_scan(object fields) {
    LogScan out;
    out.scan = header_.lidar;
    out.time_increment = time_increment_;
    out.scan.ranges.reserve(header_.beams);
    has_stamp_ = false;
    has_own_angles_ = false;
    lidar_.clear();
    members_.clear();
    unread_of_line_.clear();
    for (auto field : fields) {
      begin_member(field.unescaped_key());
      if (field_ == "t") {
        out.scan.stamp = field.value().get_double();
        has_stamp_ = true;
      } else if (field_ == "ranges") {
        read_ranges(field.value(), out.scan);
      } else if (field_ == "lidar") {
        lidar_ = std::string_view(field.value().get_string());
      } else if (field_ == "odom") {
        out.T_odom_laser = pose_or_null(field.value());
      } else if (field_ == "pose") {
        out.T_map_laser = pose_or_null(field.value());
      } else if (field_ == "kf") {
        out.is_key_scan = field.value().get_int64() != 0;
      } else if (field_ == "time_increment") {
        out.time_increment = field.value().get_double();
      } else {
        if (!read_geometry(field.value(), out.scan)) note_unread_member();
        has_own_angles_ |= field_ == "angle_min" || field_ == "angle_increment";
      }
    }
    field_.clear();
    return out;
  }

  void read_ranges(value ranges, LaserScan& scan) {
    for (value range : ranges.get_array()) {
      try {
        scan.ranges.push_back(static_cast<float>(number_or_nan(range)));
      } catch (const simdjson::simdjson_error&) {
        field_ = "ranges/" + std::to_string(scan.ranges.size());
        throw;
      }
    }
  }

  static std::string too_many_beams() { return "above " + std::to_string(LogReader::kMaxBeams); }

  Result<std::optional<LogScan>> check(LogScan scan) {
    if (!has_stamp_) return malformed_line("t: missing, expected seconds");
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
    cut_to_full_turn(scan.scan);
    if (auto error = validate(scan.scan))
      return malformed_line(error->field + ": " + error->message);
    if (auto error = find_value_beyond_limits(scan)) {
      return malformed_line((error->field == "stamp" ? "t" : error->field) + ": " + error->message);
    }
    lidars_.take(lidar_);
    return std::optional<LogScan>(std::move(scan));
  }

  simdjson::ondemand::parser json_;
  bool has_header_ = false;
  bool has_stamp_ = false;
  bool has_own_angles_ = false;  ///< The scan being read.
  std::optional<std::size_t> named_beams_;
  double time_increment_ = 0.0;    ///< Of the header.
  std::string field_;              ///< Being read, for the message of an error.
  std::set<std::string> members_;  ///< Of the object, so far.
  std::set<std::string> unread_;   ///< Members of scans.
  std::set<std::string> unread_of_line_;
  std::string lidar_;  ///< That the scan being read names; empty when it names none.
  LidarChoice lidars_;
};

}  // namespace

std::unique_ptr<ScanParser> make_json_lines_parser(std::string lidar) {
  return std::make_unique<JsonLinesParser>(std::move(lidar));
}

}  // namespace cornerfix::evaluation
