#include "core/src/localizer/localizer_impl.hpp"

#include <algorithm>
#include <utility>

#include "core/src/search/map_index.hpp"

namespace cornerfix {

void Localizer::Impl::restrict_to(std::optional<StartRegion> start_region) {
  region = std::move(start_region);
  if (region) search.restrict_to(*region, T_submap_base_link);
}

void Localizer::Impl::look_for_robot(StepTimes& times) {
  const View view = view_from(submap, T_submap_base_link);
  const double match_begin = now();
  // A search of maps that could not be ranked gives way when they can be.
  const bool can_rank_now = source && !selection.is_ranked &&
                            view.corners.size() >= kEnoughCorners &&
                            (!region || is_chosen_by_corners(*source, region));
  if (source && (can_rank_now || search.is_matching_due(view))) select_from_source(view);
  search.propose(maps, view, params.seed + scans);
  times.match_ms = now() - match_begin;

  const double verify_begin = now();
  search.judge(maps, view);
  if (source && search.is_search_due(maps, view)) select_from_source(view);
  search.search(maps, view);
  searched = search.searched();
  decide(view);
  times.verify_ms = now() - verify_begin;
}

void Localizer::Impl::select_from_source(const View& view) {
  if (selected_at == scans) return;
  selected_at = scans;
  const auto is_kept = [&](std::size_t map) {
    return (accepted && accepted->map == map) ||
           std::ranges::any_of(search.candidates().all(),
                               [map](const Candidate& one) { return one.map == map; });
  };
  MapSelection kept;
  std::vector<std::size_t> new_index(maps.size(), 0);
  for (std::size_t map = 0; map < maps.size(); ++map) {
    if (!is_kept(map)) continue;
    new_index[map] = kept.keys.size();
    kept.keys.push_back(selection.keys[map]);
    kept.maps.push_back(maps[map]);
  }
  const bool was_ranked = selection.is_ranked;
  selection =
      select_maps(*source, view,
                  {.kept = std::move(kept), .region = region, .distance_m = search.distance_m()});
  maps = selection.maps;
  if (accepted) accepted->map = new_index[accepted->map];
  search.use_selection({.new_index = new_index,
                        .free_area_m2 = source->free_area_m2(),
                        .unsearched = selection.unsearched,
                        .is_search_due = selection.is_ranked && !was_ranked});
}

void Localizer::Impl::release_other_maps() {
  if (!source) return;
  MapSelection kept;
  kept.keys = {selection.keys[accepted->map]};
  kept.maps = {maps[accepted->map]};
  search.use_selection({.new_index = std::vector<std::size_t>(maps.size(), 0),
                        .free_area_m2 = source->free_area_m2(),
                        .unsearched = 0});
  selection = std::move(kept);
  maps = selection.maps;
  accepted->map = 0;
}

void Localizer::Impl::decide(const View& view) {
  const bool was_lost = status == Status::kLost;
  status = was_lost ? Status::kLost : Status::kCollecting;
  terms = {};
  confidence = 0.0;
  const Candidates& candidates = search.candidates();
  if (search.is_suspended()) {
    reason = Reason::kSearching;
    return;
  }
  if (candidates.empty()) {
    const bool few_features =
        params.method != Method::kIndexed &&
        submap.features().size() < static_cast<std::size_t>(params.paper.min_features);
    reason = few_features ? Reason::kFewFeatures : no_match();
    if (search.only_mirror_image_fits()) reason = Reason::kMirroredScans;
    if (unsearched() != Reason::kNone) reason = unsearched();
    return;
  }
  terms = search.terms();
  confidence = terms.probability_correct;
  if (!search.acceptable()) {
    reason = candidates.missing_without_rivals();
    const bool fits_badly = reason == Reason::kNoMatch || reason == Reason::kContradicted;
    if (reason == Reason::kNoMatch || (region && fits_badly)) reason = no_match();
    if (reason != Reason::kNone && search.only_mirror_image_fits()) reason = Reason::kMirroredScans;
    // Without a ranking the maps that were searched are any.
    const bool is_any = unsearched() != Reason::kNone && !selection.is_ranked;
    const bool may_be_elsewhere =
        is_any || fits_badly || (reason == Reason::kNone && search.is_only_unsearched());
    if (may_be_elsewhere && unsearched() != Reason::kNone) reason = unsearched();
    if (reason == Reason::kNone && !was_lost) status = Status::kAmbiguous;
    return;
  }
  const Candidate& best = candidates.best();
  const ClassField& classes = maps[best.map]->index().classes;
  if (!explains_more_than_two_lines(classes, view.evidence, best.T_map_base_link)) {
    reason = Reason::kContradicted;
    return;
  }
  if (search.mirror_image_fits_better(maps, view)) {
    reason = Reason::kFewEvidence;
    return;
  }
  // A pose that new ground contradicted is not accepted again by what was seen before.
  const NewGround::Verdict verdict = new_ground.judge(
      classes, submap.evidence(), best.T_map_base_link * inverse(T_submap_base_link));
  if (verdict == NewGround::Verdict::kContradicts) {
    reason = Reason::kContradicted;
    return;
  }
  accept(best);
}

Reason Localizer::Impl::no_match() const {
  return region ? Reason::kPriorContradicted : Reason::kNoMatch;
}

Reason Localizer::Impl::unsearched() const {
  if (!source || selection.unsearched == 0) return Reason::kNone;
  const bool is_all_searched = region && !is_chosen_by_corners(*source, region);
  return selection.is_ranked || is_all_searched ? Reason::kSearching : Reason::kFewFeatures;
}

void Localizer::Impl::accept(const Candidate& best) {
  status = Status::kLocalized;
  reason = Reason::kNone;
  begin_tracking(best);
  misfits = 0;
  misfit_way_m = 0.0;
  ++epoch;
  confirmed = false;
  distance_since_acceptance_m = 0.0;
  searched_at_m = 0.0;
  accepted_index = submap.next_index();
  new_ground = NewGround(submap.evidence());
}

}  // namespace cornerfix
