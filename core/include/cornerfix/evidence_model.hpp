/// \file  How much more likely what was seen is at the true pose than at the best wrong one: the
/// model that judges poses.
///
/// Every end of a beam and every place that beams passed falls in a class by what the map holds
/// there. A class weighs ln(P(class | true pose) / P(class | best wrong pose)), learnt by counting
/// over real logs (docs/algorithm.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <cornerfix/distance_field.hpp>
#include <cornerfix/evidence_grid.hpp>
#include <cornerfix/occupancy_grid.hpp>

namespace cornerfix {

/// Upper limits of the distance classes of beam ends [m]. Beyond the near ones, known-free and
/// unknown cells are classes of their own.
inline constexpr std::array<double, 4> kNearLimits{0.05, 0.10, 0.15, 0.20};
inline constexpr std::array<double, 4> kFarLimits{0.30, 0.50, 1.00, 1e9};

inline constexpr std::size_t kEndClasses = kNearLimits.size() + 2 * kFarLimits.size();
enum class PassClass : std::uint8_t { kOnWall, kNearWall, kFree, kUnknown };
inline constexpr std::size_t kPassClasses = 4;

/// Log-likelihood ratios [nat]: near classes, then far ones in known-free space, then far ones in
/// unknown space.
inline constexpr std::array<float, kEndClasses> kEndWeights{
    0.75F, 0.43F, -0.48F, -0.79F, -1.89F, -2.25F, -2.93F, -2.52F, -0.24F, -0.25F, -0.12F, -0.35F};
inline constexpr std::array<float, kPassClasses> kPassWeights{-1.27F, -0.97F, 0.16F, -0.35F};

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

  /// Both classes as stored: the end class in the low nibble, the pass class in the high one.
  [[nodiscard]] std::uint8_t packed(int column, int row) const { return at(column, row); }

  /// Class of a cell outside the grid: far from walls, unknown.
  static constexpr std::uint8_t kOutside = static_cast<std::uint8_t>(
      (kEndClasses - 1) | (static_cast<std::size_t>(PassClass::kUnknown) << 4U));

 private:
  [[nodiscard]] std::uint8_t at(int column, int row) const {
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return kOutside;
    return classes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(column)];
  }

  Pose2 T_grid_map_;
  double resolution_ = 1.0;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> classes_;
};

/// What the evidence says of one pose.
struct EvidenceScore {
  std::array<int, kEndClasses> end_counts{};    ///< Beam ends by class.
  std::array<int, kPassClasses> pass_counts{};  ///< Passed places by class.
  double log_likelihood = 0.0;                  ///< Sum of the weights [nat].
  int ends = 0;                                 ///< Beam ends judged.
  double matched = 0.0;                         ///< Share of the ends within 0.15 m of a wall.
  double contradicted =
      0.0;               ///< Share of the ends in known-free space, more than 0.3 m from a wall.
  double blocked = 0.0;  ///< Share of the passed places that are walls.
};

/// `T_map_evidence` takes the evidence's frame into `map`. O(points), one look-up each.
[[nodiscard]] EvidenceScore score_evidence(const ClassField& classes, const Evidence& evidence,
                                           const Pose2& T_map_evidence);

/// Probability that the best pose is the true one. `gap` is its log-likelihood less that of the
/// best other pose. A logistic in the gap, the mean likelihood and the contradictions, fitted over
/// logs (docs/algorithm.md).
[[nodiscard]] double probability_right(const EvidenceScore& best, double gap);

}  // namespace cornerfix
