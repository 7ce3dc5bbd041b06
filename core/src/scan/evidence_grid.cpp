#include "core/src/scan/evidence_grid.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/src/scan/evidence_blocks.hpp"

namespace cornerfix {
EvidenceGrid::EvidenceGrid(const Point2& center, EvidenceGridParams params)
    : params_(params),
      center_(center),
      corner_(center.array() - 0.5 * params.extent_m),
      size_(static_cast<int>(std::ceil(params.extent_m / params.resolution_m))),
      tiles_per_row_((size_ + kTile - 1) / kTile),
      tile_numbers_(static_cast<std::size_t>(tiles_per_row_) *
                    static_cast<std::size_t>(tiles_per_row_)) {
  assert(tile_numbers_.size() < 65'536 && "tile numbers fit 16 bits");
}

EvidenceGrid::CellCounts& EvidenceGrid::cell(int column, int row) {
  std::uint16_t& number = tile_numbers_[tile_of(column, row)];
  if (number == 0) {
    tiles_.emplace_back();
    number = static_cast<std::uint16_t>(tiles_.size());
  }
  return tiles_[number - 1U][place_in_tile(column, row)];
}

const EvidenceGrid::CellCounts& EvidenceGrid::known_cell(int column, int row) const {
  const std::uint16_t number = tile_numbers_[tile_of(column, row)];
  return tiles_[number - 1U][place_in_tile(column, row)];
}

void EvidenceGrid::add(const LaserScan& scan, const Pose2& T_submap_laser) {
  count(scan, T_submap_laser, 1);
}

void EvidenceGrid::remove(const LaserScan& scan, const Pose2& T_submap_laser) {
  count(scan, T_submap_laser, -1);
  // A cell that is listed and empty would be listed again when it is next counted in.
  std::erase_if(touched_, [this](std::uint32_t index) {
    CellCounts& counts = cell(static_cast<int>(index) % size_, static_cast<int>(index) / size_);
    if (counts.ends != 0 || counts.passes != 0) return false;
    counts = {};
    return true;
  });
}

void EvidenceGrid::count(const LaserScan& scan, const Pose2& T_submap_laser, int sign) {
  const double scale = 1.0 / params_.resolution_m;
  const Point2 start = (T_submap_laser.translation() - corner_) * scale;
  const auto cell_at = [&](const Point2& p) -> CellCounts* {
    if (!(p.x() >= 0.0 && p.y() >= 0.0 && p.x() < size_ && p.y() < size_)) return nullptr;
    const int column = static_cast<int>(p.x());
    const int row = static_cast<int>(p.y());
    CellCounts& counts = cell(column, row);
    if (counts.ends == 0 && counts.passes == 0)
      touched_.push_back(static_cast<std::uint32_t>(row * size_ + column));
    return &counts;
  };
  double last_bearing = -1e9;
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.has_return(beam)) continue;
    const double bearing = scan.bearing(beam);
    if (std::abs(bearing - last_bearing) < params_.min_beam_spacing_rad) continue;
    last_bearing = bearing;
    const double range = static_cast<double>(scan.ranges[beam]);
    const Point2 direction{std::cos(T_submap_laser.yaw + bearing),
                           std::sin(T_submap_laser.yaw + bearing)};
    if (range <= params_.max_range_m) {
      const Point2 end = start + (range * scale) * direction;
      if (CellCounts* hit = cell_at(end)) {
        hit->ends += sign;
        hit->sum_x += static_cast<float>(sign) * static_cast<float>(end.x() - std::floor(end.x()));
        hit->sum_y += static_cast<float>(sign) * static_cast<float>(end.y() - std::floor(end.y()));
        if (sign > 0) {
          hit->origin_x = static_cast<float>(T_submap_laser.x);
          hit->origin_y = static_cast<float>(T_submap_laser.y);
        }
      }
    }
    // A beam that ends in a wall did not pass its surface.
    const double passed = std::min(range * scale - 1.5, params_.max_range_m * scale);
    for (double along = 0.5; along < passed; along += 1.0) {
      if (CellCounts* passed_cell = cell_at(start + along * direction)) passed_cell->passes += sign;
    }
  }
}

Evidence EvidenceGrid::collect() const {
  Evidence evidence;
  const int block_cells =
      std::max(1, static_cast<int>(std::lround(kBlockSize / params_.resolution_m)));
  const int blocks_per_row = size_ / block_cells + 1;
  assert(blocks_per_row < 256 && "block numbers fit 16 bits");
  std::vector<std::uint16_t> number_of(static_cast<std::size_t>(blocks_per_row * blocks_per_row),
                                       0);
  std::size_t squares = 0;
  const auto square = [&](int column, int row) {
    std::uint16_t& id = number_of[static_cast<std::size_t>((row / block_cells) * blocks_per_row +
                                                           column / block_cells)];
    if (id == 0) id = static_cast<std::uint16_t>(++squares);
    return static_cast<std::uint16_t>(id - 1);
  };
  std::vector<HitCell> hit_cells;
  for (const std::uint32_t index : touched_) {
    const auto column = static_cast<int>(index) % size_;
    const auto row = static_cast<int>(index) / size_;
    const CellCounts& cell = known_cell(column, row);
    const Point2 corner = corner_ + params_.resolution_m * Point2{column, row};
    if (cell.ends > 0) {
      if (cell.passes > 2 * cell.ends) continue;
      const Point2 mean{static_cast<double>(cell.sum_x) / cell.ends,
                        static_cast<double>(cell.sum_y) / cell.ends};
      evidence.ends.emplace_back(corner + params_.resolution_m * mean);
      evidence.origins.emplace_back(cell.origin_x, cell.origin_y);
      hit_cells.push_back({column, row, square(column, row)});
    } else if (cell.passes > 0 && column % 2 == 0 && row % 2 == 0) {
      evidence.free.emplace_back(corner + params_.resolution_m * Point2{0.5, 0.5});
      evidence.free_blocks.push_back(square(column, row));
    }
  }
  HitBlocks blocks = blocks_of_hits(hit_cells, squares);
  evidence.blocks = blocks.count;
  evidence.independent_hits = effective_squares(hit_cells, squares);
  evidence.end_blocks = std::move(blocks.of_hit);
  return evidence;
}

}  // namespace cornerfix
