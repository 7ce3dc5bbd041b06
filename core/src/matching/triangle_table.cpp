#include "core/src/matching/triangle_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "core/src/base/cross.hpp"

namespace cornerfix {
namespace {

constexpr int kUnits = 65536;  // of the longest side, and of a turn
constexpr double kUnitsPerRadian = kUnits / (2.0 * std::numbers::pi);

/// A side as seen when going round the triangle.
struct Side {
  Point2 along;
  int number;
  double squared_length = along.squaredNorm();
};

}  // namespace

std::optional<Triangle> triangle_of(const Point2& a, const Point2& b, const Point2& c,
                                    const TriangleLimits& limits) {
  std::array<Side, 3> sides{Side{b - a, 0}, Side{c - b, 1}, Side{a - c, 2}};
  for (const Side& side : sides) {
    if (side.squared_length < limits.min_side_m * limits.min_side_m ||
        side.squared_length > limits.max_side_m * limits.max_side_m)
      return std::nullopt;
  }
  std::ranges::sort(sides, std::greater<>(), &Side::squared_length);
  const auto& [longest, middle, shortest] = sides;
  Triangle triangle;
  triangle.sides = {std::sqrt(longest.squared_length), std::sqrt(middle.squared_length),
                    std::sqrt(shortest.squared_length)};
  const double distinct = 2.0 * limits.tolerance_m;
  if (triangle.sides[0] - triangle.sides[1] < distinct ||
      triangle.sides[1] - triangle.sides[2] < distinct)
    return std::nullopt;
  const double twice_area = cross(longest.along, middle.along);
  const double height = std::abs(twice_area) / triangle.sides[0];
  if (height < 2.0 * distinct) return std::nullopt;
  triangle.counter_clockwise = twice_area > 0.0;
  const bool ends_at_middle = middle.number == (longest.number + 1) % 3;
  const Point2 x_axis = ends_at_middle ? longest.along : Point2(-longest.along);
  const Point2 centroid = (a + b + c) / 3.0;
  triangle.frame = {centroid.x(), centroid.y(), std::atan2(x_axis.y(), x_axis.x())};
  return triangle;
}

TriangleTable::TriangleTable(const PointGrid& grid, const TriangleLimits& limits,
                             std::size_t max_neighbors)
    : origin_(grid.points().empty() ? Point2(0.0, 0.0) : grid.points().front()),
      units_per_m_((kUnits - 1) / limits.max_side_m),
      tolerance_(static_cast<int>(std::ceil(limits.tolerance_m * units_per_m_))),
      bin_width_(std::max(2 * tolerance_, kUnits / 64)),
      bins_((kUnits - 1) / bin_width_ + 1) {
  sort(collect(grid, limits, max_neighbors));
}

TriangleTable::BySense TriangleTable::collect(const PointGrid& grid, const TriangleLimits& limits,
                                              std::size_t max_neighbors) const {
  const std::vector<Point2>& points = grid.points();
  BySense collected;
  std::vector<std::pair<double, std::uint32_t>> near;  // by squared distance
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    near.clear();
    grid.for_each_within(points[i], limits.max_side_m,
                         [&](std::uint32_t j, double squared_distance) {
                           if (j > i) near.emplace_back(squared_distance, j);
                         });
    if (near.size() > max_neighbors) {
      std::ranges::nth_element(near, near.begin() + static_cast<std::ptrdiff_t>(max_neighbors));
      near.resize(max_neighbors);
    }
    for (std::size_t j = 1; j < near.size(); ++j) {
      for (std::size_t k = 0; k < j; ++k) {
        const auto triangle =
            triangle_of(points[i], points[near[j].second], points[near[k].second], limits);
        if (triangle) collected[triangle->counter_clockwise].push_back(stored(*triangle));
      }
    }
  }
  return collected;
}

TriangleTable::Stored TriangleTable::stored(const Triangle& triangle) const {
  const auto side = [&](double length_m) {
    return static_cast<std::uint16_t>(std::lround(length_m * units_per_m_));
  };
  const auto heading = std::lround(triangle.frame.yaw * kUnitsPerRadian) & (kUnits - 1);
  const Point2 centroid = triangle.frame.translation() - origin_;
  return {side(triangle.sides[0]),          side(triangle.sides[1]),
          side(triangle.sides[2]),          static_cast<std::uint16_t>(heading),
          static_cast<float>(centroid.x()), static_cast<float>(centroid.y())};
}

Pose2 TriangleTable::frame_of(const Stored& stored) const {
  return {origin_.x() + static_cast<double>(stored.x), origin_.y() + static_cast<double>(stored.y),
          stored.heading / kUnitsPerRadian};
}

std::size_t TriangleTable::row_of(bool counter_clockwise, int longest_bin, int middle_bin) const {
  const int row = ((counter_clockwise ? bins_ : 0) + longest_bin) * bins_ + middle_bin;
  return static_cast<std::size_t>(row);
}

void TriangleTable::sort(const BySense& collected) {
  const auto row = [&](bool counter_clockwise, const Stored& triangle) {
    return row_of(counter_clockwise, triangle.longest / bin_width_, triangle.middle / bin_width_);
  };
  offsets_.assign(row_of(true, bins_, 0) + 1, 0);
  for (const bool sense : {false, true}) {
    for (const Stored& triangle : collected[sense]) ++offsets_[row(sense, triangle)];
  }
  for (std::size_t i = 1; i < offsets_.size(); ++i) offsets_[i] += offsets_[i - 1];
  stored_.resize(offsets_.back());
  for (const bool sense : {false, true}) {
    for (const Stored& triangle : collected[sense])
      stored_[--offsets_[row(sense, triangle)]] = triangle;
  }
  for (std::size_t i = 1; i < offsets_.size(); ++i) {
    std::ranges::sort(stored_.begin() + static_cast<std::ptrdiff_t>(offsets_[i - 1]),
                      stored_.begin() + static_cast<std::ptrdiff_t>(offsets_[i]), {},
                      &Stored::shortest);
  }
}

void TriangleTable::find_congruent(const Triangle& triangle, std::vector<Pose2>& frames) const {
  const Stored sought = stored(triangle);
  const auto first_bin = [&](int side) { return std::max(0, side - tolerance_) / bin_width_; };
  const auto last_bin = [&](int side) {
    return std::min(bins_ - 1, (side + tolerance_) / bin_width_);
  };
  for (int longest = first_bin(sought.longest); longest <= last_bin(sought.longest); ++longest) {
    for (int middle = first_bin(sought.middle); middle <= last_bin(sought.middle); ++middle) {
      const std::size_t row = row_of(triangle.counter_clockwise, longest, middle);
      const auto end = stored_.begin() + static_cast<std::ptrdiff_t>(offsets_[row + 1]);
      auto it =
          std::ranges::lower_bound(stored_.begin() + static_cast<std::ptrdiff_t>(offsets_[row]),
                                   end, sought.shortest - tolerance_, {}, &Stored::shortest);
      for (; it != end && it->shortest <= sought.shortest + tolerance_; ++it) {
        if (std::abs(it->longest - sought.longest) <= tolerance_ &&
            std::abs(it->middle - sought.middle) <= tolerance_)
          frames.push_back(frame_of(*it));
      }
    }
  }
}

std::size_t TriangleTable::memory_bytes() const {
  return stored_.size() * sizeof(Stored) + offsets_.size() * sizeof(std::uint32_t);
}

}  // namespace cornerfix
