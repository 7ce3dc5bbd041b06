#include "bench/rivals/probability_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/rivals/robot_motion.hpp"

namespace cornerfix::bench {
namespace {

double log_odds(double probability) { return std::log(probability / (1.0 - probability)); }

/// The ends of a scan's beams, in `map`.
std::vector<Point2> ends_in_map(const PosedScan& scan, double max_range_m) {
  std::vector<Point2> ends =
      ends_in_base_link({scan.scan, scan.T_base_link_laser, std::nullopt}, max_range_m);
  for (Point2& end : ends) end = scan.T_map_base_link * end;
  return ends;
}

/// Adds up log odds; each scan moves a cell once, and a hit outweighs what passes.
class OddsGrid {
 public:
  OddsGrid(const ProbabilityGrid& frame, const ProbabilityGridParams& params)
      : frame_(frame),
        hit_(static_cast<float>(log_odds(params.hit_probability))),
        miss_(static_cast<float>(log_odds(params.miss_probability))),
        odds_(frame.values.size(), std::numeric_limits<float>::quiet_NaN()),
        last_scan_(frame.values.size(), 0) {}

  void insert(const Point2& origin, std::span<const Point2> ends) {
    ++scan_;
    for (const Point2& end : ends) update(cell(end), hit_);
    for (const Point2& end : ends) pass(origin, end);
  }

  [[nodiscard]] std::vector<std::uint8_t> values() const {
    std::vector<std::uint8_t> values(odds_.size(), 0);
    for (std::size_t i = 0; i < odds_.size(); ++i) {
      if (std::isnan(odds_[i])) continue;
      const double probability = 1.0 / (1.0 + std::exp(-static_cast<double>(odds_[i])));
      const double share =
          (probability - ProbabilityGrid::kMin) / (ProbabilityGrid::kMax - ProbabilityGrid::kMin);
      values[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
    }
    return values;
  }

 private:
  [[nodiscard]] std::size_t cell(const Point2& point) const {
    const auto column =
        static_cast<std::size_t>((point.x() - frame_.origin_map.x()) / frame_.resolution);
    const auto row =
        static_cast<std::size_t>((point.y() - frame_.origin_map.y()) / frame_.resolution);
    return row * static_cast<std::size_t>(frame_.width) + column;
  }

  void update(std::size_t cell, float odds) {
    if (last_scan_[cell] == scan_) return;
    last_scan_[cell] = scan_;
    static const auto kMinOdds = static_cast<float>(log_odds(ProbabilityGrid::kMin));
    static const auto kMaxOdds = static_cast<float>(log_odds(ProbabilityGrid::kMax));
    const float before = std::isnan(odds_[cell]) ? 0.0F : odds_[cell];
    odds_[cell] = std::clamp(before + odds, kMinOdds, kMaxOdds);
  }

  void pass(const Point2& origin, const Point2& end) {
    const double half_cell = 0.5 * frame_.resolution;
    const Point2 ray = end - origin;
    const int steps = static_cast<int>(ray.norm() / half_cell);
    for (int i = 0; i < steps; ++i) update(cell(origin + ray * i / steps), miss_);
  }

  const ProbabilityGrid& frame_;
  float hit_;
  float miss_;
  std::uint32_t scan_ = 0;
  std::vector<float> odds_;  ///< NaN where nothing was seen.
  std::vector<std::uint32_t> last_scan_;
};

}  // namespace

ProbabilityGrid build_probability_grid(std::span<const PosedScan> scans,
                                       const ProbabilityGridParams& params) {
  ProbabilityGrid grid;
  grid.resolution = params.resolution_m;
  if (scans.empty()) return grid;
  Point2 low = scans.front().T_map_base_link.translation();
  Point2 high = low;
  const auto extend = [&](const Point2& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  };
  for (const PosedScan& scan : scans) {
    extend((scan.T_map_base_link * scan.T_base_link_laser).translation());
    for (const Point2& end : ends_in_map(scan, params.max_range_m)) extend(end);
  }
  grid.origin_map = low - Point2::Constant(params.resolution_m);
  const Point2 cells = (high - grid.origin_map) / params.resolution_m;
  grid.width = static_cast<int>(cells.x()) + 2;
  grid.height = static_cast<int>(cells.y()) + 2;
  grid.values.resize(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  OddsGrid odds(grid, params);
  for (const PosedScan& scan : scans) {
    const Point2 origin = (scan.T_map_base_link * scan.T_base_link_laser).translation();
    odds.insert(origin, ends_in_map(scan, params.max_range_m));
  }
  grid.values = odds.values();
  return grid;
}

}  // namespace cornerfix::bench
