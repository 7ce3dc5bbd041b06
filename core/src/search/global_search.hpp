/// \file  Looks through whole maps for the places where the robot may be.
///
/// Proposals are cheap and come whenever a scan joins the submap: corners, or the paper's
/// descriptors. A whole map is searched by branch and bound, which alone can exclude other poses.
/// This is done before a pose is accepted, and from time to time until then, more often where
/// corners are few.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/localizer_params.hpp>

#include "core/src/local_map/view.hpp"
#include "core/src/search/candidates.hpp"
#include "core/src/search/place_search.hpp"

namespace cornerfix {

class GlobalSearch {
 public:
  explicit GlobalSearch(const LocalizerParams& params)
      : params_(params), candidates_(params.acceptance) {}

  /// The same maps at each call, or more behind them.
  using Maps = std::span<const LocalizationMapPtr>;

  /// Forgets all: what comes is not where the robot was.
  void reset();
  void move_along(const Pose2& motion);

  /// Where the robot may be by what it sees, to be verified. `seed` varies random draws.
  void propose(Maps maps, const View& view, std::uint64_t seed);
  /// Judges all candidates anew, and looks through maps where that is due.
  void verify(Maps maps, const View& view);

  /// Judges a tracked pose and its rivals anew, after a search of whole maps if
  /// `search_maps`.
  /// Returns whether it did.
  bool review(Maps maps, const View& view, const Candidate& tracked, bool search_maps);
  /// A confirmed pose is not compared with rivals again.
  void clear_candidates() { candidates_.clear(); }

  [[nodiscard]] const Candidates& candidates() const { return candidates_; }
  /// What the decision on the best candidate weighs, by what the last search would have found.
  [[nodiscard]] AcceptanceTerms terms() const { return candidates_.terms(rival_margin_); }
  /// Whether it may be accepted.
  [[nodiscard]] bool acceptable() const { return candidates_.acceptable(rival_margin_); }
  /// Whether verify() looked through maps.
  [[nodiscard]] bool searched() const { return searched_; }
  /// Whether the best candidate's map holds the mirror image of what was seen, and better: then
  /// what was seen is symmetric, or the lidar is mounted upside down.
  [[nodiscard]] bool mirror_image_fits_better(Maps maps, const View& view) const;

 private:
  /// When something was last done: by how much was seen and driven then.
  struct Moment {
    std::size_t ends = 0;
    double way_m = 0.0;
  };

  /// Into one map, as far as it has come.
  struct Look {
    Look(const PlaceSearch& map, const View& view) : run(map, view.evidence.ends, view.way, {}) {}
    PlaceSearch::Run run;
    std::size_t places = 0;
  };
  using Looks = std::vector<std::optional<Look>>;  ///< By map.

  void match_corners(Maps maps, const View& view, std::uint64_t seed);
  void match_descriptors(Maps maps, const View& view, std::uint64_t seed);
  [[nodiscard]] bool is_due(const Moment& last, const View& view, double growth,
                            double way_m) const;
  [[nodiscard]] bool search_due(Maps maps, const View& view) const;
  [[nodiscard]] double best_mean(Maps maps, const View& view) const;
  void search_whole(Maps maps, const View& view);
  void search(Maps maps, const View& view, Looks& looks);
  [[nodiscard]] bool asks_corners_of(std::size_t map, Maps maps, const View& view) const;
  void look_by_corners(std::size_t map, Maps maps, const View& view, double min_mean_weight);
  [[nodiscard]] double margin_to_look_at() const;
  [[nodiscard]] std::vector<std::size_t> likeliest_first(std::size_t maps) const;
  [[nodiscard]] double optimistic_mean(Maps maps, const View& view, const Candidate& place) const;

  LocalizerParams params_;
  Candidates candidates_;
  std::vector<Candidate> proposed_;
  double way_m_ = 0.0;
  Moment matched_;
  Moment searched_at_;
  bool searched_ = false;
  double rival_margin_ = kRivalMargin;  ///< Farther below the best, a hit, none was looked for.
};

}  // namespace cornerfix
