#include "core/src/scan/evidence_blocks.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace cornerfix {
namespace {

// Cells of an object that counts alone.
constexpr std::size_t kLeastCells = 3;

/// Finds the objects that the hits of each square form.
class ObjectFinder {
 public:
  explicit ObjectFinder(std::span<const HitCell> cells)
      : cells_(cells), is_taken_(cells.size(), false) {
    if (cells.empty()) return;
    const auto [left, right] = std::ranges::minmax(cells, {}, &HitCell::column);
    const auto [low, high] = std::ranges::minmax(cells, {}, &HitCell::row);
    // A border of one cell on each side, so that every cell has all its neighbours.
    first_column_ = left.column - 1;
    first_row_ = low.row - 1;
    width_ = right.column - left.column + 3;
    hit_at_.assign(
        static_cast<std::size_t>(width_) * static_cast<std::size_t>(high.row - low.row + 3), kNone);
    for (std::size_t hit = 0; hit < cells.size(); ++hit)
      hit_at_[place(cells[hit].column, cells[hit].row)] = static_cast<std::uint32_t>(hit);
  }

  /// The hits of the object that `seed` belongs to; none if an earlier call returned it.
  [[nodiscard]] std::vector<std::size_t> object_of(std::size_t seed) {
    std::vector<std::size_t> hits;
    take(seed, hits);
    for (std::size_t next = 0; next < hits.size(); ++next) take_neighbours(hits[next], hits);
    return hits;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  [[nodiscard]] std::size_t place(int column, int row) const {
    return static_cast<std::size_t>(row - first_row_) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column - first_column_);
  }

  void take(std::size_t hit, std::vector<std::size_t>& hits) {
    if (is_taken_[hit]) return;
    is_taken_[hit] = true;
    hits.push_back(hit);
  }

  void take_neighbours(std::size_t hit, std::vector<std::size_t>& hits) {
    const HitCell& cell = cells_[hit];
    for (int row = cell.row - 1; row <= cell.row + 1; ++row) {
      for (int column = cell.column - 1; column <= cell.column + 1; ++column) {
        const std::uint32_t neighbour = hit_at_[place(column, row)];
        if (neighbour != kNone && cells_[neighbour].square == cell.square) take(neighbour, hits);
      }
    }
  }

  std::span<const HitCell> cells_;
  std::vector<bool> is_taken_;
  int first_column_ = 0;
  int first_row_ = 0;
  int width_ = 0;
  std::vector<std::uint32_t> hit_at_;  ///< By place, or kNone.
};

}  // namespace

HitBlocks blocks_of_hits(std::span<const HitCell> cells, std::size_t square_count) {
  HitBlocks blocks;
  blocks.count = square_count;
  blocks.of_hit.resize(cells.size());
  std::ranges::transform(cells, blocks.of_hit.begin(), &HitCell::square);
  ObjectFinder finder(cells);
  for (std::size_t seed = 0; seed < cells.size(); ++seed) {
    const std::vector<std::size_t> object = finder.object_of(seed);
    if (object.size() < kLeastCells) continue;
    if (blocks.count > std::numeric_limits<std::uint16_t>::max()) break;
    for (const std::size_t hit : object)
      blocks.of_hit[hit] = static_cast<std::uint16_t>(blocks.count);
    ++blocks.count;
  }
  return blocks;
}

double effective_squares(std::span<const HitCell> cells, std::size_t square_count) {
  if (cells.empty()) return 0.0;
  std::vector<double> counts(square_count, 0.0);
  for (const HitCell& cell : cells) counts[cell.square] += 1.0;
  const double squares = std::inner_product(counts.begin(), counts.end(), counts.begin(), 0.0);
  const auto all = static_cast<double>(cells.size());
  return all * all / squares;
}

}  // namespace cornerfix
