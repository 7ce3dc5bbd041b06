#include "core/src/scan/longest_lines.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cornerfix {
namespace {

constexpr int kDirections = 180;    // 1 deg apart
constexpr double kHalfWidth = 0.2;  // of a line; also the spacing of the Hough cells [m]

/// The points p with normal . p = offset.
struct HitLine {
  Point2 normal;
  double offset = 0.0;
  [[nodiscard]] bool holds(const Point2& p) const {
    return std::abs(normal.dot(p) - offset) < kHalfWidth;
  }
};

/// Hits by their distance from the origin along one normal, in cells of kHalfWidth.
class OffsetCounts {
 public:
  explicit OffsetCounts(double max_offset)
      : max_offset_(max_offset),
        counts_(static_cast<std::size_t>(2.0 * max_offset / kHalfWidth) + 2) {}

  /// Counts for another normal.
  void count(std::span<const Point2> hits, const Point2& normal) {
    std::ranges::fill(counts_, 0);
    for (const Point2& p : hits)
      ++counts_[static_cast<std::size_t>((normal.dot(p) + max_offset_) / kHalfWidth)];
  }

  struct Band {
    int hits = 0;
    double offset = 0.0;  ///< Of its middle [m].
  };
  /// The two neighbouring cells with the most hits.
  [[nodiscard]] Band fullest() const {
    Band fullest;
    for (std::size_t cell = 0; cell + 1 < counts_.size(); ++cell) {
      const int hits = counts_[cell] + counts_[cell + 1];
      if (hits > fullest.hits)
        fullest = {hits, static_cast<double>(cell + 1) * kHalfWidth - max_offset_};
    }
    return fullest;
  }

 private:
  double max_offset_;
  std::vector<int> counts_;
};

HitLine fullest_line(std::span<const Point2> hits) {
  double max_offset = 0.0;
  for (const Point2& p : hits) max_offset = std::max(max_offset, p.norm());
  OffsetCounts counts(max_offset);
  int most = 0;
  HitLine fullest{Point2::UnitX()};
  for (int i = 0; i < kDirections; ++i) {
    const double angle = std::numbers::pi * i / kDirections;
    const Point2 normal(std::cos(angle), std::sin(angle));
    counts.count(hits, normal);
    const OffsetCounts::Band band = counts.fullest();
    if (band.hits <= most) continue;
    most = band.hits;
    fullest = {normal, band.offset};
  }
  return fullest;
}

/// Least squares over the hits that the line holds.
HitLine fitted(const HitLine& line, std::span<const Point2> hits) {
  double n = 0.0;
  Point2 mean = Point2::Zero();
  for (const Point2& p : hits) {
    if (!line.holds(p)) continue;
    n += 1.0;
    mean += p;
  }
  if (n < 2.0) return line;
  mean /= n;
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (const Point2& p : hits) {
    if (!line.holds(p)) continue;
    const Point2 d = p - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double direction = 0.5 * std::atan2(2.0 * xy, xx - yy);
  const Point2 normal(-std::sin(direction), std::cos(direction));
  return {normal, normal.dot(mean)};
}

}  // namespace

std::vector<bool> are_on_longest_lines(std::span<const Point2> hits, int count) {
  std::vector<bool> are_on_lines(hits.size(), false);
  std::vector<Point2> others(hits.begin(), hits.end());
  for (int i = 0; i < count && !others.empty(); ++i) {
    const HitLine line = fitted(fullest_line(others), others);
    for (std::size_t hit = 0; hit < hits.size(); ++hit)
      are_on_lines[hit] = are_on_lines[hit] || line.holds(hits[hit]);
    std::erase_if(others, [&](const Point2& p) { return line.holds(p); });
  }
  return are_on_lines;
}

}  // namespace cornerfix
