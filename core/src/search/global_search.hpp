/// \file  Looks through whole maps for the places where the robot may be.
///
/// Proposals are cheap and come whenever a scan joins the submap: corners, or the paper's
/// descriptors. A whole map is searched by branch and bound, which alone can exclude other poses.
/// This is done before a pose is accepted, and from time to time until then, more often where
/// corners are few. A search that exceeds the work budget of one scan continues at the next scans.
/// It answers where the robot was when it began. Its poses are moved along and judged by all
/// evidence.
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
#include "core/src/search/search_region.hpp"
#include "core/src/search/work_budget.hpp"

namespace cornerfix {

inline constexpr std::size_t kFewMaps = 4;        ///< Are searched whole; of more, corners choose.
inline constexpr std::size_t kEnoughCorners = 6;  ///< To distinguish poses by.

class GlobalSearch {
 public:
  explicit GlobalSearch(const LocalizerParams& params)
      : params_(params), candidates_(params.acceptance) {}

  /// The same maps at each call, or more behind them.
  using Maps = std::span<const LocalizationMapPtr>;

  /// Forgets all: what comes is not where the robot was.
  void reset();
  void move_along(const Pose2& motion);

  /// Restricts the search. The robot has moved by `T_start_base_link` since its first scan.
  void restrict_to(const StartRegion& region, const Pose2& T_start_base_link);
  /// Poses everywhere may be searched from now on.
  void lift_restriction();

  /// Where the robot may be by what it sees, to be verified. `seed` varies random draws.
  void propose(Maps maps, const View& view, std::uint64_t seed);
  /// Judges all candidates and proposals anew.
  void judge(Maps maps, const View& view);
  /// Then searches whole maps where that is due.
  void search(Maps maps, const View& view);

  /// Driven since the search began [m].
  [[nodiscard]] double distance_m() const { return way_m_; }
  /// Whether propose() would compare corners with maps now.
  [[nodiscard]] bool is_matching_due(const View& view) const;
  /// Whether search() would begin a search now.
  [[nodiscard]] bool is_search_due(Maps maps, const View& view) const {
    return !whole_ && search_due(maps, view);
  }
  /// Maps that were selected among more. Those with candidates are among them.
  struct Selected {
    std::span<const std::size_t> new_index;  ///< By the index before; of no meaning where it left.
    double free_area_m2 = 0.0;               ///< Of all maps.
    std::size_t unsearched = 0;              ///< Others that may hold the robot.
    /// Ranked, while those before were not: their search does not count.
    bool is_search_due = false;
  };
  /// From now on maps are those of a selection. Not while a search is suspended.
  void use_selection(const Selected& selected);
  /// Whether the best candidate would be accepted if no map were unsearched.
  [[nodiscard]] bool is_only_unsearched() const {
    return candidates_.is_only_unsearched(rival_margin_);
  }

  /// Judges a tracked pose and its rivals anew, and begins a search of whole maps if
  /// `search_maps`. Returns whether a search ended.
  bool review(Maps maps, const View& view, const Candidate& tracked, bool search_maps);
  /// Whether a search of whole maps waits for the next scan to continue. Until then no pose may be
  /// accepted.
  [[nodiscard]] bool is_suspended() const { return whole_.has_value(); }
  /// A confirmed pose is not compared with rivals again.
  void clear_candidates() { candidates_.clear(); }

  [[nodiscard]] const Candidates& candidates() const { return candidates_; }
  /// What the decision on the best candidate weighs, by what the last search would have found.
  [[nodiscard]] AcceptanceTerms terms() const { return candidates_.terms(rival_margin_); }
  /// Whether it may be accepted.
  [[nodiscard]] bool acceptable() const { return candidates_.acceptable(rival_margin_); }
  /// Whether a search of whole maps ended in verify().
  [[nodiscard]] bool searched() const { return searched_; }
  /// Whether the best candidate's map holds the mirror image of what was seen, and better: then
  /// what was seen is symmetric, or the lidar is mounted upside down.
  [[nodiscard]] bool mirror_image_fits_better(Maps maps, const View& view) const;
  /// Whether the last search that found nothing to accept found the mirror image of what was seen.
  [[nodiscard]] bool only_mirror_image_fits() const { return only_mirror_image_fits_; }

 private:
  /// When something was last done: by how much was seen and driven then.
  struct Moment {
    std::size_t ends = 0;
    double way_m = 0.0;
  };

  /// Into one map, as far as it has come.
  struct Look {
    Look(const PlaceSearch& map, const View& view, const PlaceSearchParams& params)
        : run(map, view.evidence.ends, view.way, params) {}
    PlaceSearch::Run run;
    std::size_t places = 0;
  };

  /// A search of all maps, as far as it has come.
  struct WholeSearch {
    std::vector<LocalizationMapPtr> maps;    ///< Kept alive.
    View view;                               ///< When it began,
    std::optional<SearchRegion> region;      ///< when it began,
    Pose2 motion;                            ///< of base_link since then.
    std::vector<std::optional<Look>> looks;  ///< By map.
    // One pass over the maps. A second one follows if the first finds a pose that deserves a deeper
    // search than the maps before it got.
    std::vector<std::size_t> order;  ///< Maps still to be searched, the next one last.
    bool is_by_corners = true;       ///< Those that corners choose come before the others.
    bool is_second_pass = false;
    double best = 0.0;  ///< Mean log-likelihood ratio that no map may fall far below [nat].
    double searched_down_to = 0.0;
  };

  struct RegionArea {
    double all_m2 = 0.0;     ///< Of the maps that it was made from: to notice new ones.
    double region_m2 = 0.0;  ///< Of the region.
  };

  /// Begins the budget of a scan.
  void judge_again(Maps maps, const View& view);
  /// In units of WorkBudget.
  [[nodiscard]] std::int64_t half_budget() const;
  void match_corners(Maps maps, const View& view, std::uint64_t seed);
  void match_descriptors(Maps maps, const View& view, std::uint64_t seed);
  [[nodiscard]] bool is_due(const Moment& last, const View& view, double growth,
                            double way_m) const;
  [[nodiscard]] bool search_due(Maps maps, const View& view) const;
  [[nodiscard]] double searched_area_m2(Maps maps);
  [[nodiscard]] bool may_be_in(const LocalizationMap& map) const;
  /// Considers a candidate that may be the robot's, after its refinement.
  void consider(const LocalizationMap& map, const View& view, const Candidate& candidate);
  [[nodiscard]] bool is_outdated(Maps maps) const;
  [[nodiscard]] double best_mean() const;
  void begin_search(Maps maps, const View& view);
  void begin_pass();
  /// Continues the search within the budget of one scan. Returns whether it ended.
  bool continue_search(const View& view);
  /// Continues one pass over the maps. Returns whether it ended.
  bool continue_pass(const View& view);
  /// Returns whether the map was searched to the end.
  bool search_map(std::size_t map, const View& view);
  [[nodiscard]] bool asks_corners_of(std::size_t map, Maps maps, const View& view) const;
  void look_by_corners(std::size_t map, const View& view, double min_mean_weight);
  [[nodiscard]] double margin_to_look_at() const;
  [[nodiscard]] bool has_mirror_image(Maps maps, const View& view, double free_area_m2);
  [[nodiscard]] std::vector<std::size_t> likeliest_last(std::size_t maps) const;
  /// The weight of a candidate in a search.
  [[nodiscard]] static double optimistic_mean(Maps maps, const View& view, const Candidate& place);

  LocalizerParams params_;
  std::optional<SearchRegion> region_;  ///< Where the robot may be now; nothing: everywhere.
  std::optional<RegionArea> region_area_;
  std::optional<double> whole_area_m2_;  ///< Of all maps, when some of them were selected.
  Candidates candidates_;
  std::optional<WholeSearch> whole_;
  std::vector<Candidate> proposed_;
  double way_m_ = 0.0;
  Moment matched_;
  Moment searched_at_;
  bool searched_ = false;
  WorkBudget budget_;  ///< Of the present scan.
  bool is_mirror_search_due_ = false;
  bool only_mirror_image_fits_ = false;
  double rival_margin_ = kRivalMargin;  ///< Farther below the best, a hit, none was looked for.
};

}  // namespace cornerfix
