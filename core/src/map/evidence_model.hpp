/// \file  How much more likely what was seen is at the true pose than at the best wrong one: the
/// model that judges poses.
///
/// Every end of a beam and every place that beams passed falls in a class by what the map holds
/// there. A class weighs ln(P(class | true pose) / P(class | best wrong pose)), learnt by counting
/// over real logs (docs/method/05-acceptance.md).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/answer.hpp>
#include <cornerfix/occupancy_grid.hpp>

#include "core/src/map/distance_field.hpp"
#include "core/src/scan/evidence_grid.hpp"

namespace cornerfix {

/// Upper limits of the distance classes of hits [m]. Beyond the near ones, known-free and
/// unknown cells are classes of their own.
inline constexpr std::array<double, 4> kNearLimits{0.05, 0.10, 0.15, 0.20};
inline constexpr std::array<double, 4> kFarLimits{0.30, 0.50, 1.00, 1e9};

inline constexpr std::size_t kFieldClasses = kNearLimits.size() + 2 * kFarLimits.size();
/// An end behind a mapped wall that the beam must have passed, near a wall of its own or not.
inline constexpr std::size_t kHiddenNear = kFieldClasses;
inline constexpr std::size_t kHiddenFar = kFieldClasses + 1;
static_assert(kEndClasses == kFieldClasses + 2);
enum class PassClass : std::uint8_t { kOnWall, kNearWall, kFree, kUnknown };
static_assert(kPassClasses == 4);

/// Weights of the classes [nat]: near ones, far ones in known-free space, far ones in unknown
/// space, hidden ones; then of the places that beams passed.
struct EvidenceWeights {
  std::array<float, kEndClasses> ends;
  std::array<float, kPassClasses> passes;
};
/// ln(P(class | true pose) / P(class | plausible wrong pose)), learnt in one round of calibration:
/// what the search ranks places by.
inline constexpr EvidenceWeights kSearchWeights{
    {0.41F, -0.14F, -0.72F, -0.77F, -1.20F, -1.24F, -1.03F, -0.47F, -0.10F, -0.10F, -0.10F, -0.10F,
     -0.10F, -1.30F},
    {-0.90F, -0.62F, 0.11F, -0.44F}};
/// The same, learnt in the next round, over the poses that a search by the first table finds. It
/// separates the correct one from its rivals.
inline constexpr EvidenceWeights kRivalWeights{
    {0.35F, -0.12F, -0.63F, -0.68F, -1.11F, -1.20F, -1.16F, -0.90F, -0.10F, -0.10F, -0.10F, -0.10F,
     -0.10F, -1.30F},
    {-0.81F, -0.59F, 0.06F, -0.16F}};

/// The classes of a map's cells, two nibbles a cell. Immutable.
class ClassField {
 public:
  ClassField() = default;
  /// O(cells).
  ClassField(const OccupancyGrid& grid, const DistanceField& field);

  [[nodiscard]] std::size_t end_class(int column, int row) const { return at(column, row) & 15U; }
  [[nodiscard]] std::size_t pass_class(int column, int row) const { return at(column, row) >> 4U; }
  [[nodiscard]] const Pose2& T_grid_map() const { return T_grid_map_; }
  [[nodiscard]] double resolution() const { return resolution_; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::size_t bytes() const { return classes_.size(); }

  /// Both classes as stored: the end class in the low nibble, the pass class in the high one.
  [[nodiscard]] std::uint8_t packed(int column, int row) const { return at(column, row); }

  /// Both classes of the cell that holds a point, in cells of the grid.
  [[nodiscard]] std::uint8_t packed(const Point2& cells) const {
    const bool is_inside =
        cells.x() >= 0.0 && cells.y() >= 0.0 && cells.x() < width_ && cells.y() < height_;
    if (!is_inside) return kOutside;
    return classes_[static_cast<std::size_t>(cells.y()) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(cells.x())];
  }

  /// Whether a wall stands between the two ends of each beam. It must also block the beams 0.1 m to
  /// either side: a beam that grazes a wall, within the error of a correct pose, is not blocked.
  /// The wall that a beam ends in does not count. Points in cells of the grid; O(free places along
  /// the beams).
  [[nodiscard]] std::vector<std::uint8_t> walls_between(std::span<const Point2> from_cells,
                                                        std::span<const Point2> to_cells) const;

  /// Class of a cell outside the grid: far from walls, unknown.
  static constexpr std::uint8_t kOutside = static_cast<std::uint8_t>(
      (kFieldClasses - 1) | (static_cast<std::size_t>(PassClass::kUnknown) << 4U));

 private:
  /// One beam on its way through the cells.
  struct Walk {
    Walk(const Point2& the_from, const Point2& to)
        : from(the_from),
          length((to - from).norm()),
          direction((to - from) / std::max(length, 1e-9)) {}
    Point2 from;
    double length;
    Point2 direction;
    double along = 0.0;
    bool has_entered = false;  ///< A wall,
    bool has_left = false;     ///< and free space again.
    [[nodiscard]] bool is_done() const { return has_left || !(along < length); }
  };
  void step(Walk& walk) const;
  /// Whether lines enter a wall and leave it again, each.
  [[nodiscard]] std::vector<std::uint8_t> are_crossed(std::span<const Point2> from_cells,
                                                      std::span<const Point2> to_cells) const;

  [[nodiscard]] std::uint8_t at(int column, int row) const {
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return kOutside;
    return classes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(column)];
  }

  Pose2 T_grid_map_;
  double resolution_ = 1.0;
  std::array<double, kFieldClasses> stride_{};  ///< By end class, cells of the way to skip.
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> classes_;
};

/// The end class of each hit. `T_map_evidence` takes the evidence's frame into `map`. One look-up
/// per hit, and a few along the beam of each hit whose origin is known.
[[nodiscard]] std::vector<std::uint8_t> hit_classes(const ClassField& classes,
                                                    const Evidence& evidence,
                                                    const Pose2& T_map_evidence);
/// Whether hits of a class lie within 0.15 m of a wall that the robot can see.
[[nodiscard]] bool is_explained(std::size_t end_class);

/// The classes of hits and of passed points at a pose, counted. Cost as of hit_classes(), and one
/// look-up per passed point.
[[nodiscard]] EvidenceScore score_evidence(const ClassField& classes, const Evidence& evidence,
                                           const Pose2& T_map_evidence);

/// Hits that explained_share() judges: within 0.15 m of a wall, more than 0.3 m from any wall in
/// known-free space, and hidden behind walls.
[[nodiscard]] int judged_hits(const EvidenceScore& score);

/// Share of the judged hits that lie within 0.15 m of a wall; 1 without judged hits. Hits in
/// unknown space do not count.
[[nodiscard]] double explained_share(const EvidenceScore& score);

}  // namespace cornerfix
