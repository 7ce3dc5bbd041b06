#include <charconv>
#include <numbers>
#include <string_view>

#include "cli/scan_parser.hpp"

namespace cornerfix::cli {

namespace {

/// A SICK LMS reports 81.9 m and a little less for "nothing there"; CARMEN logs do not say.
constexpr double kRangeMax = 80.0;

/// The blank-separated words of a line.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  std::string_view next() {
    const std::size_t begin = rest_.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    rest_.remove_prefix(begin);
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(word.size());
    return word;
  }

  template <typename Number>
  std::optional<Number> next_number() {
    const std::string_view word = next();
    Number number{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
    return number;
  }

  std::optional<Pose2> next_pose() {
    const auto x = next_number<double>();
    const auto y = next_number<double>();
    const auto yaw = next_number<double>();
    if (!x || !y || !yaw) return std::nullopt;
    return Pose2{*x, *y, wrap_angle(*yaw)};
  }

 private:
  std::string_view rest_;
};

/// FLASER does not tell its angles: half a turn, with both ends when the number of beams is odd.
LaserScan half_turn_lidar(std::size_t beams) {
  LaserScan lidar;
  lidar.angle_min = -std::numbers::pi / 2.0;
  lidar.angle_increment =
      std::numbers::pi / static_cast<double>(beams % 2 == 0 ? beams : beams - 1);
  lidar.range_min = 0.0;
  lidar.range_max = kRangeMax;
  return lidar;
}

class CarmenParser final : public ScanParser {
 public:
  Result<std::optional<LogScan>> parse(const std::string& line) override {
    Words words(line);
    if (words.next() != "FLASER") return std::optional<LogScan>();
    const auto beams = words.next_number<std::size_t>();
    if (!beams || *beams < 2) return malformed("expected a number of beams above 1");
    if (header_.beams == 0) {
      header_.beams = *beams;
      header_.lidar = half_turn_lidar(*beams);
    }
    if (*beams != header_.beams) {
      return malformed(std::to_string(*beams) + " beams, expected " +
                       std::to_string(header_.beams) + " as in the first scan");
    }
    return parse_scan(words);
  }

 private:
  static Error malformed(std::string_view message) {
    return {ErrorCode::kMalformed, "FLASER: " + std::string(message), ""};
  }

  /// ranges, laser pose, odometry, ipc_timestamp, then host and logger_timestamp, which are ours
  /// to ignore.
  Result<std::optional<LogScan>> parse_scan(Words& words) const {
    LogScan out;
    out.scan = header_.lidar;
    out.scan.ranges.reserve(header_.beams);
    for (std::size_t beam = 0; beam < header_.beams; ++beam) {
      const auto range = words.next_number<float>();
      if (!range) return malformed("expected " + std::to_string(header_.beams) + " ranges");
      out.scan.ranges.push_back(*range);
    }
    out.T_map_laser = words.next_pose();
    if (!out.T_map_laser) return malformed("expected x y theta of the laser");
    out.T_odom_laser = words.next_pose();
    if (!out.T_odom_laser) return malformed("expected odom_x odom_y odom_theta");
    const auto stamp = words.next_number<double>();
    if (!stamp) return malformed("expected a timestamp");
    out.scan.stamp = *stamp;
    return std::optional<LogScan>(std::move(out));
  }
};

}  // namespace

std::unique_ptr<ScanParser> make_carmen_parser() { return std::make_unique<CarmenParser>(); }

}  // namespace cornerfix::cli
