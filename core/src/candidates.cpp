#include "candidates.hpp"

#include <algorithm>
#include <utility>

#include "same_place.hpp"

namespace cornerfix {

void Candidates::move_along(const Pose2& motion) {
  for (Candidate& place : places_) place.T_map_base_link = place.T_map_base_link * motion;
}

void Candidates::consider(const LocalizationMap& map, const View& view, Candidate candidate) {
  candidate.T_map_base_link =
      refined_coarse_to_fine(map.field(), view.evidence.ends, candidate.T_map_base_link);
  candidate.score = score_evidence(map.classes(), view.evidence, candidate.T_map_base_link);
  if (Candidate* same = find(candidate.map, candidate.T_map_base_link)) {
    candidate.votes = std::max(same->votes, candidate.votes);
    candidate.inliers = std::max(same->inliers, candidate.inliers);
    if (same->score.fit > candidate.score.fit) {
      same->votes = candidate.votes;
      same->inliers = candidate.inliers;
    } else {
      *same = candidate;
    }
  } else {
    places_.push_back(candidate);
  }
  const auto fit = [](const Candidate& place) { return place.score.fit; };
  std::ranges::stable_sort(places_, std::ranges::greater{}, fit);
  const double least = best().score.fit - kRivalMargin * best().score.ends;
  std::erase_if(places_, [&](const Candidate& place) { return fit(place) < least; });
  if (places_.size() > kMaxPlaces) places_.resize(kMaxPlaces);
}

void Candidates::judge_again(std::span<const LocalizationMapPtr> maps, const View& view) {
  for (const Candidate& place : std::exchange(places_, {})) consider(*maps[place.map], view, place);
}

bool Candidates::knows(std::size_t map, const Pose2& T_map_base_link) const {
  return std::ranges::any_of(places_, [&](const Candidate& place) {
    return place.map == map && is_same_place(place.T_map_base_link, T_map_base_link);
  });
}

Candidate* Candidates::find(std::size_t map, const Pose2& T_map_base_link) {
  const auto same = std::ranges::find_if(places_, [&](const Candidate& place) {
    return place.map == map && is_same_place(place.T_map_base_link, T_map_base_link);
  });
  return same == places_.end() ? nullptr : &*same;
}

double Candidates::gap(double margin) const {
  double gap = gap_without_rivals(margin);
  for (const Candidate& rival : all().subspan(1))
    gap = std::min(gap, best().score.log_likelihood - rival.score.log_likelihood);
  return gap;
}

double Candidates::gap_without_rivals(double margin) const {
  const EvidenceScore& score = best().score;
  return std::min(score.log_likelihood - kMinPlaceWeight * score.ends, margin * score.ends);
}

bool Candidates::acceptable(double gap) const {
  const EvidenceScore& score = best().score;
  return gap >= acceptance_.min_mean_gap * score.ends && gap >= acceptance_.min_gap &&
         probability_right(score, gap) >= acceptance_.min_probability;
}

double Candidates::needed_gap(double probability) const {
  const EvidenceScore& score = best().score;
  return std::max(
      {gap_for(score, probability), acceptance_.min_gap, acceptance_.min_mean_gap * score.ends});
}

Reason Candidates::missing_without_rivals() const {
  const double gap = gap_without_rivals(kRivalMargin);
  if (gap <= 0.0) return Reason::kNoMatch;
  if (acceptable(gap)) return Reason::kNone;
  const auto is_probable = [&](const EvidenceScore& score) {
    return probability_right(score, gap) >= acceptance_.min_probability;
  };
  EvidenceScore uncontradicted = best().score;
  uncontradicted.contradicted = 0.0;
  return !is_probable(best().score) && is_probable(uncontradicted) ? Reason::kContradicted
                                                                   : Reason::kFewEvidence;
}

}  // namespace cornerfix
