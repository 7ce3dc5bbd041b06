/// \file  Feature points of one frame: corners kept across scans, merged by non-maximum
/// suppression.
///
/// Peng et al. 2023, section 2.2 and the end of algorithm 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Grows by the corners of scans. A corner seen again, if both times its sigma is known, joins the
/// feature's mean; of other near ones the one with the highest weight keeps its place. No two
/// features are ever within the suppression radius of each other.
/// Value type; not synchronised. Memory O(features); a corner costs O(1) on average, by a hash of
/// cells.
class FeatureMap {
 public:
  explicit FeatureMap(FeatureMapParams params = {});

  /// Merges `corners`, given in this map's frame, seen in one scan. A corner of the same sense and
  /// direction as a feature within the radius is that feature seen again: position, direction and
  /// turn become the inverse-variance mean. Any other corner weaker than a feature within the
  /// radius adds to the count of the nearest one. A corner stronger than all of them takes their
  /// place and their counts. A scan adds at most one to a count. Positions must be finite and
  /// within 1e8 radii of the origin.
  void insert(std::span<const Feature> corners);

  /// In the order of first sight, but for features that a stronger corner between them made one:
  /// the last feature then moves up to the freed place.
  [[nodiscard]] const std::vector<Feature>& features() const { return features_; }

  /// Those seen in at least `min_count` scans.
  [[nodiscard]] std::vector<Feature> repeated(int min_count) const;

  /// Indices of the features within the radius of a place, nearest first. O(1) on average.
  [[nodiscard]] std::vector<std::size_t> neighbors(const Point2& position) const;

 private:
  using Cell = std::uint64_t;  ///< Column and row of a cell as large as the radius.

  [[nodiscard]] Cell cell_of(const Point2& position, int columns_off = 0, int rows_off = 0) const;
  void insert(const Feature& corner);
  void append(const Feature& corner);
  void fuse(std::size_t index, const Feature& corner);
  void move(std::size_t index, const Point2& position);
  void absorb(std::vector<std::size_t> weaker, const Feature& corner);
  void remove(std::size_t index);
  void forget_cell(std::size_t index);
  void count_scan(std::size_t index);

  FeatureMapParams params_;
  int scan_ = 0;  ///< Scans inserted so far.
  std::vector<Feature> features_;
  std::vector<int> last_scan_;  ///< Per feature, the last scan that it counted.
  std::unordered_multimap<Cell, std::size_t> cells_;  ///< Feature indices by cell.
};

}  // namespace cornerfix
