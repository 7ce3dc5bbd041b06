#include "core/src/search/global_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/src/matching/pose_estimator.hpp"
#include "core/src/search/corner_hypotheses.hpp"
#include "core/src/search/map_index.hpp"
#include "core/src/search/same_place.hpp"

namespace cornerfix {
namespace {

// What calls for another look: so many times more seen, or so far driven [m].
constexpr double kGrowth = 1.6;
constexpr double kWay = 3.0;
constexpr double kRareGrowth = 2.5;  // where corners speak
constexpr double kRareWay = 6.0;

// Judged in one search of a map; poses below the last are unsearched. More when the best candidate
// is acceptable but for them, as in a building of equal rooms.
constexpr std::size_t kMaxPlacesPerMap = 64;
constexpr std::size_t kMaxPlacesToAccept = 256;
constexpr std::size_t kMaxCornerMatches = 4;  // new ones at a time
// In units of WorkBudget: one hit of a candidate refined and scored, one map searched by corners.
constexpr std::size_t kWorkPerHit = 100;
constexpr std::size_t kWorkPerCornerLook = 100'000;
// Rivals that are searched for when a pose may be accepted, per hit [nat].
constexpr double kDecisionMargin = 0.2;
constexpr double kSeedMargin =
    0.15;  // as kRivalMargin, when no pose can be accepted now: what may win later
constexpr double kCornerSlack = 0.15;  // by which the ends about one corner may misjudge it [nat]
constexpr double kMirrorSlack = 0.1;  // by which the weights of a search may misjudge a place [nat]
constexpr double kMinMirrorWeight = 0.1;  // of a mirror image that explains what was seen [nat]
constexpr double kMirrorLogOdds = 2.3;    // that what was seen must have against its image [nat]
constexpr double kMirrorMargin = 0.05;    // by which what was seen must fit better than its image

double free_area_of(GlobalSearch::Maps maps) {
  double area = 0.0;
  for (const LocalizationMapPtr& map : maps) area += map->free_area_m2();
  return area;
}

}  // namespace

void GlobalSearch::reset() { *this = GlobalSearch(params_); }

void GlobalSearch::move_along(const Pose2& motion) {
  way_m_ += motion.translation().norm();
  if (region_) region_->move_along(motion);
  if (whole_) whole_->motion = whole_->motion * motion;
  candidates_.move_along(motion);
}

// --- region

void GlobalSearch::restrict_to(const StartRegion& region, const Pose2& T_start_base_link) {
  region_.emplace(region, T_start_base_link);
  region_area_.reset();
}

void GlobalSearch::lift_restriction() {
  if (region_) whole_.reset();
  region_.reset();
}

bool GlobalSearch::may_be_in(const LocalizationMap& map) const {
  return !region_ || region_->is_in(map);
}

double GlobalSearch::searched_area_m2(Maps maps) {
  const double all_m2 = whole_area_m2_.value_or(free_area_of(maps));
  if (!region_) return all_m2;
  if (!region_area_ || region_area_->all_m2 != all_m2) {
    region_area_ = RegionArea{.all_m2 = all_m2};
    for (const LocalizationMapPtr& map : maps)
      region_area_->region_m2 += region_->free_area_m2(*map);
  }
  return region_area_->region_m2;
}

void GlobalSearch::consider(const LocalizationMap& map, const View& view,
                            const Candidate& candidate) {
  if (region_) {
    if (!region_->is_in(map)) return;
    const Pose2 refined =
        refined_coarse_to_fine(map.index().field, view.evidence.ends, candidate.T_map_base_link);
    if (!region_->contains(refined)) return;
  }
  candidates_.consider(map, view, candidate);
  budget_.charge(kWorkPerHit * view.evidence.ends.size());
}

// --- proposals

void GlobalSearch::propose(Maps maps, const View& view, std::uint64_t seed) {
  proposed_.clear();
  if (params_.method != Method::kIndexed) {
    if (view.corners.size() >= static_cast<std::size_t>(params_.paper.min_features))
      match_descriptors(maps, view, seed);
  } else if (is_due(matched_, view, kGrowth, kWay)) {
    match_corners(maps, view, seed);
  }
}

void GlobalSearch::match_corners(Maps maps, const View& view, std::uint64_t seed) {
  std::vector<std::pair<double, Candidate>> found;
  for (std::size_t map = 0; map < maps.size(); ++map) {
    if (!may_be_in(*maps[map])) continue;
    for (const Hypothesis& one :
         hypotheses_from_corners(*maps[map], view.corners, view.evidence.ends, {.seed = seed})) {
      if (!candidates_.knows(map, one.T_map_base_link))
        found.push_back({one.mean_weight, {map, one.T_map_base_link, 0, 0, {}}});
    }
  }
  std::ranges::stable_sort(found, std::ranges::greater{},
                           [](const auto& one) { return one.first; });
  for (const auto& [mean_weight, place] :
       std::span(found).first(std::min(found.size(), kMaxCornerMatches)))
    proposed_.push_back(place);
  matched_ = {view.evidence.ends.size(), way_m_};
}

/// NMA or RMA, RANSAC on the pairs of the best matches (eqs. 15-18).
void GlobalSearch::match_descriptors(Maps maps, const View& view, std::uint64_t seed) {
  const auto max_matches = static_cast<std::size_t>(params_.paper.max_matches);
  SampledMatchParams sampling = params_.paper.sampling;
  sampling.seed = seed;
  PoseEstimatorParams estimator = params_.paper.estimator;
  estimator.seed = params_.seed;
  for (std::size_t map = 0; map < maps.size(); ++map) {
    if (!may_be_in(*maps[map])) continue;
    const DescriptorIndex& index = maps[map]->index().descriptor_index;
    const std::vector<Feature>& mapped = maps[map]->features();
    const DescriptorSet local = describe(view.corners, index.params());
    const std::vector<DescriptorMatch> matches =
        params_.method == Method::kNma
            ? match_exhaustive(local, index, params_.paper.min_votes, max_matches)
            : match_sampled(local, index, params_.paper.min_votes, max_matches, sampling);
    for (const DescriptorMatch& match : matches) {
      std::vector<Correspondence> correspondences;
      const auto global = describe_one(mapped, match.global_feature, index.params());
      for (const auto& [m, n] :
           pairs_of(match, local[match.local_feature], global, local.angle_bins()))
        correspondences.push_back({view.corners[m].position, mapped[n].position});
      if (const auto estimate = estimate_pose(correspondences, estimator)) {
        proposed_.push_back({map,
                             estimate->T_map_submap,
                             match.votes,
                             static_cast<int>(estimate->inliers.size()),
                             {}});
      }
    }
  }
}

// --- verification

void GlobalSearch::judge_again(Maps maps, const View& view) {
  budget_ = WorkBudget(params_.search_budget_ms);
  candidates_.set_free_area(searched_area_m2(maps));
  budget_.charge(kWorkPerHit * view.evidence.ends.size() * candidates_.all().size());
  candidates_.judge_again(maps, view);
}

void GlobalSearch::judge(Maps maps, const View& view) {
  judge_again(maps, view);
  for (const Candidate& place : proposed_) consider(*maps[place.map], view, place);
  if (is_outdated(maps)) whole_.reset();
  if (!whole_) rival_margin_ = kRivalMargin;  // of no search yet
}

void GlobalSearch::search(Maps maps, const View& view) {
  if (!whole_ && search_due(maps, view)) begin_search(maps, view);
  searched_ = whole_ && continue_search(view);
  if (searched_) {
    is_mirror_search_due_ = candidates_.empty() || !candidates_.may_be_accepted();
    only_mirror_image_fits_ = only_mirror_image_fits_ && is_mirror_search_due_;
  }
  if (whole_ || !is_mirror_search_due_ || budget_.left() < half_budget()) return;
  is_mirror_search_due_ = false;
  only_mirror_image_fits_ = has_mirror_image(maps, view, searched_area_m2(maps));
}

bool GlobalSearch::review(Maps maps, const View& view, const Candidate& tracked, bool search_maps) {
  judge_again(maps, view);
  candidates_.consider(*maps[tracked.map], view, tracked);
  if (is_outdated(maps)) whole_.reset();
  if (!whole_ && search_maps) begin_search(maps, view);
  searched_ = whole_ && continue_search(view);
  return searched_;
}

bool GlobalSearch::is_matching_due(const View& view) const {
  if (whole_) return false;
  return params_.method != Method::kIndexed || is_due(matched_, view, kGrowth, kWay);
}

void GlobalSearch::use_selection(const Selected& selected) {
  whole_.reset();
  region_area_.reset();
  whole_area_m2_ = selected.free_area_m2;
  candidates_.renumber_maps(selected.new_index);
  candidates_.set_unsearched_maps(selected.unsearched);
  if (selected.is_search_due) searched_at_ = {};
}

/// Whether maps were replaced since the search began.
bool GlobalSearch::is_outdated(Maps maps) const {
  return whole_ && !std::ranges::equal(whole_->maps, maps);
}

void GlobalSearch::begin_search(Maps maps, const View& view) {
  rival_margin_ = kRivalMargin;
  whole_ = WholeSearch();
  whole_->maps.assign(maps.begin(), maps.end());
  whole_->view = view;
  whole_->region = region_;
  whole_->looks.resize(maps.size());
  searched_at_ = {view.evidence.ends.size(), way_m_};
  begin_pass();
}

void GlobalSearch::begin_pass() {
  whole_->is_by_corners = true;
  whole_->order = likeliest_last(whole_->maps.size());
  whole_->best = best_mean();
  whole_->searched_down_to = -std::numeric_limits<double>::infinity();
}

std::int64_t GlobalSearch::half_budget() const {
  return WorkBudget(0.5 * params_.search_budget_ms).left();
}

bool GlobalSearch::continue_search(const View& view) {
  // Candidates with many hits leave little. So that the search ends, it gets half at least.
  if (budget_.left() < half_budget()) budget_ = WorkBudget(0.5 * params_.search_budget_ms);
  while (continue_pass(view)) {
    const bool is_deep_enough = candidates_.empty() || !candidates_.may_be_accepted() ||
                                rival_margin_ >= margin_to_look_at();
    if (is_deep_enough || whole_->is_second_pass) {
      whole_.reset();
      return true;
    }
    whole_->is_second_pass = true;
    begin_pass();
  }
  return false;
}

bool GlobalSearch::is_due(const Moment& last, const View& view, double growth, double way_m) const {
  return last.ends == 0 ||
         static_cast<double>(view.evidence.ends.size()) >=
             growth * static_cast<double>(last.ends) ||
         way_m_ - last.way_m >= way_m;
}

bool GlobalSearch::search_due(Maps maps, const View& view) const {
  // The gap to the second best means nothing while the second best may not have been looked at.
  if (!candidates_.empty() && acceptable()) return true;
  if (params_.method != Method::kIndexed) return false;
  // Many maps wait for corners to choose among them, a while.
  if (!region_ && maps.size() > kFewMaps && view.corners.size() < kEnoughCorners && way_m_ < kWay)
    return false;
  return view.corners.size() < kEnoughCorners ? is_due(searched_at_, view, kGrowth, kWay)
                                              : is_due(searched_at_, view, kRareGrowth, kRareWay);
}

/// What no map may fall far below, by the view when the search began.
double GlobalSearch::best_mean() const {
  double best = kMinPlaceWeight + kRivalMargin;
  const Pose2 back = inverse(whole_->motion);
  for (Candidate place : candidates_.all()) {
    place.T_map_base_link = place.T_map_base_link * back;
    best = std::max(best, optimistic_mean(whole_->maps, whole_->view, place));
  }
  return best;
}

/// Searches all maps for poses that come near the best candidate, and near the best of these.
/// Corners come first, so that a map where they find one is searched whole, too: no pose may be
/// accepted in a map whose other poses were not searched.
bool GlobalSearch::continue_pass(const View& view) {
  WholeSearch& whole = *whole_;
  const double least_by_corners = whole.best - margin_to_look_at();
  while (whole.is_by_corners) {
    if (whole.order.empty()) {
      whole.is_by_corners = false;
      whole.order = likeliest_last(whole.maps.size());
      whole.best = best_mean();
      break;
    }
    const std::size_t map = whole.order.back();
    whole.order.pop_back();
    if (!asks_corners_of(map, whole.maps, whole.view)) continue;
    look_by_corners(map, view, least_by_corners);
    budget_.charge(kWorkPerCornerLook);
    if (budget_.is_spent()) return false;
  }
  for (; !whole.order.empty(); whole.order.pop_back()) {
    const std::size_t map = whole.order.back();
    if (!may_be_in(*whole.maps[map]) || asks_corners_of(map, whole.maps, whole.view)) continue;
    if (!search_map(map, view)) return false;
  }
  rival_margin_ = std::min(kRivalMargin, whole.best - whole.searched_down_to);
  return true;
}

bool GlobalSearch::search_map(std::size_t map, const View& view) {
  WholeSearch& whole = *whole_;
  std::optional<Look>& look = whole.looks[map];
  if (!look) {
    look.emplace(whole.maps[map]->index().place_search, whole.view,
                 PlaceSearchParams{.region = whole.region});
  }
  double least = whole.best - margin_to_look_at();
  const auto max_places = [&] {
    return candidates_.may_be_accepted() ? kMaxPlacesToAccept : kMaxPlacesPerMap;
  };
  while (look->places < kMaxPlacesPerMap || look->places < max_places()) {
    least = whole.best - margin_to_look_at();
    const std::optional<Place> place = look->run.next(least, budget_);
    if (place) {
      ++look->places;
      whole.best = std::max(whole.best, place->mean_weight);
      consider(*whole.maps[map], view, {map, place->T_map_base_link * whole.motion, 0, 0, {}});
    }
    if (budget_.is_spent()) return false;
    if (!place) break;
  }
  whole.searched_down_to = std::max({whole.searched_down_to, least, look->run.bound()});
  return true;
}

/// Whether corners are enough to search a map. They are not where they are few, nor in a map that
/// has a candidate near the best, because a similar pose may be close.
bool GlobalSearch::asks_corners_of(std::size_t map, Maps maps, const View& view) const {
  const double margin = margin_to_look_at();
  const bool may_have_robot = std::ranges::any_of(candidates_.all(), [&](const Candidate& place) {
    const EvidenceScore& best = candidates_.best().score;
    return place.map == map && place.score.fit >= best.fit - margin * best.ends;
  });
  return !region_ && maps.size() > kFewMaps && !may_have_robot &&
         view.corners.size() >= kEnoughCorners;
}

void GlobalSearch::look_by_corners(std::size_t map, const View& view, double min_mean_weight) {
  const LocalizationMap& searched = *whole_->maps[map];
  for (const Hypothesis& one :
       hypotheses_from_corners(searched, whole_->view.corners, whole_->view.evidence.ends,
                               {.min_mean_weight = min_mean_weight - kCornerSlack}))
    consider(searched, view, {map, one.T_map_base_link * whole_->motion, 0, 0, {}});
}

/// How far below the best candidate, per hit, a pose may lie and still matter. An endless minimum
/// margin asks for all rivals.
double GlobalSearch::margin_to_look_at() const {
  if (candidates_.empty() || std::isinf(params_.acceptance.min_gap)) return kRivalMargin;
  if (!candidates_.may_be_accepted()) return kSeedMargin;
  const double ends = std::max(1, candidates_.best().score.ends);
  return std::min(kRivalMargin, std::max({kDecisionMargin, params_.acceptance.min_gap / ends,
                                          params_.acceptance.min_mean_gap}));
}

/// Maps, those with the better candidates last, where the search begins: the higher the bound, the
/// shorter the search.
std::vector<std::size_t> GlobalSearch::likeliest_last(std::size_t maps) const {
  std::vector<std::size_t> rank(maps, Candidates::kMaxPlaces);
  for (std::size_t i = candidates_.all().size(); i-- > 0;) rank[candidates_.all()[i].map] = i;
  std::vector<std::size_t> order(maps);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t map) { return rank[map]; });
  std::ranges::reverse(order);
  return order;
}

double GlobalSearch::optimistic_mean(Maps maps, const View& view, const Candidate& place) {
  return maps[place.map]->index().place_search.mean_weight(
      view.evidence.ends, view.way, PlaceSearchParams{}.max_points, place.T_map_base_link);
}

/// Whether a map explains the mirror image of what was seen, and clearly better than the best
/// candidate explains what was seen.
bool GlobalSearch::has_mirror_image(Maps maps, const View& view, double free_area_m2) {
  if (maps.size() > kFewMaps && !region_) return false;
  const View image = mirrored(view);
  const PlaceSearchParams search{.region =
                                     region_ ? std::optional(region_->mirrored()) : std::nullopt};
  Candidates images(params_.acceptance);
  images.set_free_area(free_area_m2);
  for (std::size_t map = 0; map < maps.size(); ++map) {
    if (!may_be_in(*maps[map])) continue;
    PlaceSearch::Run run(maps[map]->index().place_search, image.evidence.ends, image.way, search);
    if (const auto place = run.next(kMinMirrorWeight, budget_))
      images.consider(*maps[map], image, {map, place->T_map_base_link, 0, 0, {}});
  }
  if (images.empty()) return false;
  const EvidenceScore& best = images.best().score;
  const double fit =
      candidates_.empty() ? kMinPlaceWeight * best.ends : candidates_.best().score.fit;
  return best.fit >= fit + kMirrorMargin * best.ends &&
         images.terms_without_rivals(kRivalMargin).probability_explained >=
             params_.acceptance.min_probability;
}

bool GlobalSearch::mirror_image_fits_better(Maps maps, const View& view) const {
  const Candidate& best = candidates_.best();
  const LocalizationMap& map = *maps[best.map];
  const View image = mirrored(view);
  const PlaceSearchParams search{
      .min_mean_weight = optimistic_mean(maps, view, best) - kMirrorSlack,
      .max_mean_gap = kMirrorSlack,
      .region = region_ ? std::optional(region_->mirrored()) : std::nullopt};
  return std::ranges::any_of(
      map.index().place_search.find(image.evidence.ends, image.way, search),
      [&](const Place& place) {
        const Pose2 T_map_base_link =
            refined_coarse_to_fine(map.index().field, image.evidence.ends, place.T_map_base_link);
        const EvidenceScore score =
            score_evidence(map.index().classes, image.evidence, T_map_base_link);
        return score.fit >= best.score.fit - kMirrorMargin * best.score.ends ||
               rival_log_odds(best.score, score) < kMirrorLogOdds;
      });
}

}  // namespace cornerfix
