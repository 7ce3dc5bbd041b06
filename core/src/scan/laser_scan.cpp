#include <cornerfix/laser_scan.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace cornerfix {

namespace {

std::string scan_number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string not_scan_value(double value) { return ", not " + scan_number_text(value); }

constexpr double kScanTurn = 2.0 * std::numbers::pi;

double field_of_view(const LaserScan& scan) {
  return std::abs(scan.angle_increment) * static_cast<double>(scan.ranges.size());
}

/// Whether the beams go on beyond a full turn. One beam's width of slack: some drivers repeat the
/// first bearing as the last.
bool exceeds_full_turn(const LaserScan& scan) {
  return field_of_view(scan) > kScanTurn + 2.0 * std::abs(scan.angle_increment) + 1e-3;
}

/// Cosines and sines of the bearings of a scan's beams. They are kept for the next scan, which most
/// likely has the same beams: to compute them takes longer than to compute points from them.
class BeamDirections {
 public:
  std::span<const Point2> of(const LaserScan& scan) {
    const bool is_same = scan.angle_min == angle_min_ && scan.angle_increment == angle_increment_;
    if (!is_same) directions_.clear();
    angle_min_ = scan.angle_min;
    angle_increment_ = scan.angle_increment;
    for (std::size_t beam = directions_.size(); beam < scan.ranges.size(); ++beam) {
      const double bearing = scan.bearing(beam);
      directions_.emplace_back(std::cos(bearing), std::sin(bearing));
    }
    return directions_;
  }

 private:
  double angle_min_ = 0.0;
  double angle_increment_ = 0.0;
  std::vector<Point2> directions_;
};

}  // namespace

bool cut_to_full_turn(LaserScan& scan) {
  constexpr double kLongestOverlap = 0.25 * kScanTurn;
  if (!exceeds_full_turn(scan) || field_of_view(scan) > kScanTurn + kLongestOverlap) return false;
  constexpr double kRounding = 1e-3;  // [beams]
  const double beams = kScanTurn / std::abs(scan.angle_increment) + kRounding;
  scan.ranges.resize(static_cast<std::size_t>(beams));
  return true;
}

std::optional<Error> validate(const LaserScan& scan) {
  const auto broken = [](const char* field, const std::string& message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!std::isfinite(scan.stamp)) return broken("stamp", "must be a finite number of seconds");
  constexpr double kFarthestBearing = 1e6;  // [rad]; beyond it a beam's bearing loses its digits
  if (!(std::abs(scan.angle_min) <= kFarthestBearing))
    return broken("angle_min", "must be a finite angle in radians, at most 1e6 to either side" +
                                   not_scan_value(scan.angle_min));
  if (!(std::abs(scan.angle_increment) <= kScanTurn) || scan.angle_increment == 0.0) {
    return broken("angle_increment",
                  "must be a finite angle in radians, not zero, at most a full turn" +
                      not_scan_value(scan.angle_increment));
  }
  if (!std::isfinite(scan.range_min) || scan.range_min < 0.0) {
    return broken("range_min", "must be a finite length in metres, not negative" +
                                   not_scan_value(scan.range_min));
  }
  if (!(scan.range_max > scan.range_min)) {
    return broken("range_max", "must be a length in metres above range_min, or infinite" +
                                   not_scan_value(scan.range_max));
  }
  if (exceeds_full_turn(scan)) {
    return broken("ranges", "cover more than a full turn at this angle_increment: " +
                                std::to_string(scan.ranges.size()) + " beams times " +
                                scan_number_text(scan.angle_increment) +
                                " rad; are these degrees?");
  }
  return std::nullopt;
}

std::vector<Point2> returns_as_points(const LaserScan& scan) {
  thread_local BeamDirections last_directions;
  const std::span<const Point2> directions = last_directions.of(scan);
  std::vector<Point2> points;
  points.reserve(scan.ranges.size());
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.has_return(beam)) continue;
    points.emplace_back(static_cast<double>(scan.ranges[beam]) * directions[beam]);
  }
  return points;
}

}  // namespace cornerfix
