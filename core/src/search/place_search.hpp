/// \file  All places of a map where a set of points fits, by branch and bound over the whole map
/// and all headings.
///
/// After Hess et al. 2016 (real-time loop closure in 2D lidar SLAM, section V). A pyramid of maxima
/// bounds the score of every pose in a block of cells, so that most of the map is never examined.
/// Unlike there, the result is *distinct* poses, best first and as far down as requested, because
/// the decision needs the margin over the second. There is one level of blocks, and neighbouring
/// ones are scored at once. Some of the points come first; their mean differs from that of all
/// points by less than a slack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/pose2.hpp>

#include "core/src/map/evidence_model.hpp"
#include "core/src/search/search_region.hpp"

namespace cornerfix {

struct PlaceSearchParams {
  int max_points = 100;              ///< Of the ends, evenly thinned; in [1, 2000].
  double min_mean_weight = 0.0;      ///< Places with less a point are left out [nat].
  double max_mean_gap = 0.3;         ///< And places this much below the best one [nat].
  std::size_t max_places = 12;       ///< >= 1
  double distinct_distance_m = 1.0;  ///< Places nearer than this and
  double distinct_angle_rad = 0.26;  ///< turned by less than this are one.
  std::size_t max_expansions =
      150'000;  ///< Bounds the work; the best places found by then are returned.
  std::optional<SearchRegion> region{};  ///< Poses outside are not searched.
};

struct Place {
  Pose2 T_map_base_link;   ///< To about a cell (0.2 m) and a step of heading (2 deg).
  double mean_weight = 0;  ///< Optimistic mean weight of the points [nat].
};

struct PlaceFields;
class WorkBudget;

/// Immutable: any threads may share it. 10 bytes a 0.2 m cell of the map with its border.
class PlaceSearch {
 public:
  explicit PlaceSearch(const ClassField& classes);
  ~PlaceSearch();
  PlaceSearch(PlaceSearch&&) noexcept;

  /// \param ends_base_link  Where beams ended, in base_link at the pose asked for.
  /// \param way_base_link   Where the robot has been, which should be free space.
  /// base_link itself is looked for in known-free space only.
  /// \return Distinct places, best first.
  [[nodiscard]] std::vector<Place> find(std::span<const Point2> ends_base_link,
                                        std::span<const Point2> way_base_link,
                                        const PlaceSearchParams& params) const;

  /// The same, place by place.
  class Run;

  /// The weight of a pose in this search: a bound for poses that could matter beside it.
  [[nodiscard]] double mean_weight(std::span<const Point2> ends_base_link,
                                   std::span<const Point2> way_base_link, int max_points,
                                   const Pose2& T_map_base_link) const;

  /// Sum of the optimistic weights of hits, each the best within about 0.2 m [nat].
  [[nodiscard]] double sum_of_weights(std::span<const Point2> ends_base_link,
                                      const Pose2& T_map_base_link) const;

  /// Of its pyramids, in memory.
  [[nodiscard]] std::size_t bytes() const;

 private:
  std::unique_ptr<const PlaceFields> fields_;
};

/// The places of one question. Refers to the search that it was made from.
class PlaceSearch::Run {
 public:
  Run(const PlaceSearch& search, std::span<const Point2> ends_base_link,
      std::span<const Point2> way_base_link, const PlaceSearchParams& params);
  ~Run();
  Run(Run&&) noexcept;

  /// The best place that was not given yet. Nothing when none has at least this mean weight [nat],
  /// when `max_expansions` is reached, or when the budget is spent: then the next call continues.
  /// Each call makes some progress.
  [[nodiscard]] std::optional<Place> next(double min_mean_weight, WorkBudget& budget);
  /// No place that was not given yet has a higher mean weight [nat]. That of the best there can be
  /// when there is nothing to look for, or base_link is too far from it to be looked up.
  [[nodiscard]] double bound() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cornerfix
