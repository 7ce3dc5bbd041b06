#include "core/src/search/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/src/search/map_index.hpp"
#include "core/src/search/same_place.hpp"

namespace cornerfix {

void Candidates::move_along(const Pose2& motion) {
  for (Candidate& place : places_) place.T_map_base_link = place.T_map_base_link * motion;
}

void Candidates::consider(const LocalizationMap& map, const View& view, Candidate candidate) {
  candidate.T_map_base_link =
      refined_coarse_to_fine(map.index().field, view.evidence.ends, candidate.T_map_base_link);
  candidate.score = score_evidence(map.index().classes, view.evidence, candidate.T_map_base_link);
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

AcceptanceTerms Candidates::terms(double depth) const { return terms(depth, unsearched_maps_); }

AcceptanceTerms Candidates::terms(double depth, std::size_t unsearched_maps) const {
  std::vector<double> log_odds;
  const std::vector<OtherPose> others = other_poses();
  for (const Candidate& rival : all().subspan(1))
    log_odds.push_back(rival_log_odds(best().score, rival.score, others));
  if (unsearched_maps > 0) log_odds.push_back(-std::log(static_cast<double>(unsearched_maps)));
  return weigh(best().score, margin(depth), log_odds, free_area_m2_);
}

std::vector<OtherPose> Candidates::other_poses() const {
  constexpr double kSameHeading = 0.05;  // [rad]
  std::vector<OtherPose> others;
  for (const Candidate& one : all().subspan(1)) {
    const bool is_shifted =
        one.map == best().map &&
        angle_between(one.T_map_base_link, best().T_map_base_link) < kSameHeading;
    others.push_back({&one.score, is_shifted});
  }
  return others;
}

AcceptanceTerms Candidates::terms_without_rivals(double depth) const {
  return weigh(best().score, margin_without_rivals(depth), {}, free_area_m2_);
}

double Candidates::margin_without_rivals(double depth) const {
  const EvidenceScore& score = best().score;
  return std::min(score.log_likelihood - kMinPlaceWeight * score.ends, depth * score.ends);
}

double Candidates::margin(double depth) const {
  double margin = margin_without_rivals(depth);
  for (const Candidate& rival : all().subspan(1))
    margin = std::min(margin, best().score.log_likelihood - rival.score.log_likelihood);
  return margin;
}

bool Candidates::acceptable(double depth) const {
  // The log-odds of the rivals cost most and only lower the probability.
  return acceptable(weigh(best().score, margin(depth), {}, free_area_m2_)) &&
         acceptable(terms(depth));
}

bool Candidates::acceptable(const AcceptanceTerms& terms) const {
  return terms.margin_per_hit >= acceptance_.min_mean_gap &&
         terms.margin_per_hit * best().score.ends >= acceptance_.min_gap &&
         terms.probability_correct >= acceptance_.min_probability;
}

bool Candidates::is_only_unsearched(double depth) const {
  return unsearched_maps_ > 0 && acceptable(terms(depth, 0));
}

Reason Candidates::missing_without_rivals() const {
  if (margin_without_rivals(kRivalMargin) <= 0.0) return Reason::kNoMatch;
  const AcceptanceTerms terms = terms_without_rivals(kRivalMargin);
  if (acceptable(terms)) return Reason::kNone;
  constexpr double kMostlyExplained = 0.7;
  return terms.explained_share < kMostlyExplained ? Reason::kContradicted : Reason::kFewEvidence;
}

}  // namespace cornerfix
