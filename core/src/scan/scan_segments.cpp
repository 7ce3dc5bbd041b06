#include "core/src/scan/scan_segments.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

namespace cornerfix {
namespace {

/// The returns of a scan. Turns the bearing on by a rotation a beam: a sine and a cosine for each
/// would take longer than all the rest of the extraction.
std::vector<ScanPoint> points_of(const LaserScan& scan) {
  std::vector<ScanPoint> points;
  points.reserve(scan.ranges.size());
  const double step_cos = std::cos(scan.angle_increment);
  const double step_sin = std::sin(scan.angle_increment);
  double c = std::cos(scan.angle_min);
  double s = std::sin(scan.angle_min);
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (scan.has_return(beam)) {
      const auto range = static_cast<double>(scan.ranges[beam]);
      points.push_back({{range * c, range * s}, range, static_cast<std::uint32_t>(beam)});
    }
    const double turned = c * step_cos - s * step_sin;
    s = s * step_cos + c * step_sin;
    c = turned;
  }
  return points;
}

bool is_full_turn(const LaserScan& scan) {
  const double step = std::abs(scan.angle_increment);
  return step * (static_cast<double>(scan.ranges.size()) + 0.5) >= 2.0 * std::numbers::pi;
}

/// Whether two points can lie on one surface: no farther apart than neighbours on a wall seen at
/// the smallest incidence.
class Neighborhood {
 public:
  Neighborhood(const LaserScan& scan, const ScanSegmentParams& params)
      : gap_(params.gap_m),
        gap_per_range_(std::abs(scan.angle_increment) / std::sin(params.min_incidence_rad)) {}

  [[nodiscard]] bool holds(const ScanPoint& a, const ScanPoint& b) const {
    const double reach = gap_ + std::min(a.range, b.range) * gap_per_range_;
    return (a.position - b.position).squaredNorm() <= reach * reach;
  }

 private:
  double gap_;
  double gap_per_range_;
};

/// Angle between beams and a piece of surface: how far it goes across them against how far along.
/// Extents instead of the end points, which may be anywhere on a piece that surrounds the lidar.
double incidence(std::span<const ScanPoint> piece, const LaserScan& scan) {
  const auto [nearest, farthest] = std::ranges::minmax_element(piece, {}, &ScanPoint::range);
  const std::size_t beams = scan.ranges.size();
  const std::size_t beams_across = (piece.back().beam + beams - piece.front().beam) % beams;
  const double across =
      nearest->range * std::abs(scan.angle_increment) * static_cast<double>(beams_across);
  return std::atan2(across, farthest->range - nearest->range);
}

}  // namespace

std::optional<Error> validate(const ScanSegmentParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.gap_m > 0.0) || !std::isfinite(params.gap_m)) {
    return broken("gap_m", "must be a finite length in metres above 0");
  }
  if (!(params.min_incidence_rad > 0.0 && params.min_incidence_rad < std::numbers::pi / 2.0)) {
    return broken("min_incidence_rad", "must be an angle in (0, pi/2)");
  }
  if (params.min_points < 2) return broken("min_points", "must be at least 2");
  return std::nullopt;
}

std::vector<ScanSegment> cut_into_segments(const LaserScan& scan, const ScanSegmentParams& params) {
  std::vector<ScanSegment> segments;
  std::vector<ScanPoint> points = points_of(scan);
  const auto min_points = static_cast<std::size_t>(params.min_points);
  if (points.size() < min_points) return segments;

  const Neighborhood neighborhood(scan, params);
  const auto far_apart = [&](const ScanPoint& a, const ScanPoint& b) {
    return !neighborhood.holds(a, b);
  };
  const bool joined_at_seam =
      is_full_turn(scan) && neighborhood.holds(points.back(), points.front());
  if (joined_at_seam) {
    const auto first_cut = std::ranges::adjacent_find(points, far_apart);
    if (first_cut == points.end()) return {{std::move(points), true}};
    // What lies before the first cut continues the last segment.
    std::rotate(points.begin(), first_cut + 1, points.end());
  }
  for (auto begin = points.begin(); begin != points.end();) {
    auto end = std::adjacent_find(begin, points.end(), far_apart);
    if (end != points.end()) ++end;
    const std::span<const ScanPoint> piece(begin, end);
    if (piece.size() >= min_points && incidence(piece, scan) >= params.min_incidence_rad) {
      segments.push_back({{begin, end}, false});
    }
    begin = end;
  }
  return segments;
}

}  // namespace cornerfix
