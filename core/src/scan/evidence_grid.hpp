/// \file  Hits and passed points of the scans of a submap, thinned to cells.
///
/// A wall that was seen a hundred times is one piece of evidence, not a hundred. Cells that beams
/// pass more than twice as often as they hit them are people or doors and are left out
/// (docs/method/03-local-map.md, section 3.3).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

struct EvidenceGridParams {
  double resolution_m = 0.2;  ///< One end point a cell; > 0.
  double max_range_m = 30.0;  ///< Beams count up to here; a longer one passes up to here; > 0.
  double min_beam_spacing_rad =
      0.0122;              ///< Beams nearer than this to the last one are skipped; >= 0.
  double extent_m = 96.0;  ///< Side of the square that is kept; > 0.
};

/// Points that stand for what was seen, in the frame of the grid's scans.
struct Evidence {
  std::vector<Point2> ends{};  ///< Where walls are: the mean of the hits in a cell.
  std::vector<Point2> free{};  ///< Where beams passed and none ended.
  /// From where each of `ends` was last seen, or empty when that does not matter.
  std::vector<Point2> origins{};
  /// The block of each of `ends` and of `free`, in [0, blocks) (evidence_blocks.hpp). Empty, or as
  /// long as these.
  std::vector<std::uint16_t> end_blocks{};
  std::vector<std::uint16_t> free_blocks{};
  std::size_t blocks = 0;
  /// Effective number of squares that `ends` spread over: (sum n)^2 / sum n^2 of their counts n.
  double independent_hits = 0.0;
};

/// Adds and removes whole scans; a removed scan leaves no trace. Value type; not synchronised.
/// Memory for what scans touched only: a robot sees a small part of the square.
class EvidenceGrid {
 public:
  explicit EvidenceGrid(const Point2& center = Point2::Zero(), EvidenceGridParams params = {});

  void add(const LaserScan& scan, const Pose2& T_submap_laser);
  /// With the very arguments of an earlier add().
  void remove(const LaserScan& scan, const Pose2& T_submap_laser);

  [[nodiscard]] const Point2& center() const { return center_; }
  /// O(cells touched).
  [[nodiscard]] Evidence collect() const;

 private:
  struct CellCounts {
    std::int32_t ends = 0;
    std::int32_t passes = 0;
    float sum_x = 0.0F;  ///< Of the ends, relative to the cell's corner [m].
    float sum_y = 0.0F;
    float origin_x = 0.0F;  ///< Of the last beam that ended here [m].
    float origin_y = 0.0F;
  };
  static constexpr int kTile = 4;  ///< Cells to a side of what is allocated at once.
  using Tile = std::array<CellCounts, static_cast<std::size_t>(kTile) * kTile>;

  void count(const LaserScan& scan, const Pose2& T_submap_laser, int sign);
  /// Allocates the cell's tile if need be.
  [[nodiscard]] CellCounts& cell(int column, int row);
  /// One that was counted in before.
  [[nodiscard]] const CellCounts& known_cell(int column, int row) const;
  // Unsigned: divided by shifts.
  [[nodiscard]] std::size_t tile_of(int column, int row) const {
    return static_cast<std::size_t>(row) / kTile * static_cast<std::size_t>(tiles_per_row_) +
           static_cast<std::size_t>(column) / kTile;
  }
  [[nodiscard]] static std::size_t place_in_tile(int column, int row) {
    return static_cast<std::size_t>(row) % kTile * kTile + static_cast<std::size_t>(column) % kTile;
  }

  EvidenceGridParams params_;
  Point2 center_;
  Point2 corner_;
  int size_;
  int tiles_per_row_;
  std::vector<std::uint16_t> tile_numbers_;  ///< By place: 1 + index in tiles_, or 0.
  std::deque<Tile> tiles_;
  std::vector<std::uint32_t> touched_;  ///< Cells with counts, each once.
};

}  // namespace cornerfix
