#include "core/src/localizer/localizer_impl.hpp"

#include "core/src/search/map_index.hpp"
#include "core/src/search/same_place.hpp"

namespace cornerfix {
namespace {

// Reviews of an accepted pose.
constexpr double kReviewDistance = 1.5;  // [m] between searches of the whole map
// Between reviews of a confirmed pose [m]: the local map then holds other scans (window_m).
constexpr double kConfirmedReviewDistance = 20.0;
constexpr double kConfirmDistance = 3.0;  // [m] after the acceptance

// A less certain pose is withdrawn: 0.5 m are within two standard deviations [m].
constexpr double kMaxPositionSigma = 0.25;

// Withdrawal of a pose.
constexpr double kMaxMisfitWay = 1.5;  // driven while the scans do not fit [m],
constexpr int kMinMisfits = 2;         // by at least so many scans;
constexpr int kMaxMisfits = 20;        // or so many scans, when standing

}  // namespace

void Localizer::Impl::begin_tracking(const Candidate& candidate) {
  accepted = candidate;
  tracker = PoseTracker(candidate.T_map_base_link);
  T_map_submap = candidate.T_map_base_link * inverse(T_submap_base_link);
}

void Localizer::Impl::track(const RobotScan& robot_scan, const std::vector<Point2>& points,
                            bool news) {
  const LocalizationMap& map = *maps[accepted->map];
  const TrackingVerdict verdict =
      tracker.update(map, points, robot_scan.T_base_link_laser.translation());
  accepted->T_map_base_link = tracker.T_map_base_link();
  T_map_submap = accepted->T_map_base_link * inverse(T_submap_base_link);
  if (verdict == TrackingVerdict::kFits) {
    misfits = 0;
    misfit_way_m = 0.0;
  } else {
    is_doubted = verdict == TrackingVerdict::kMisfits && stray_scans > 0;
    miss(verdict == TrackingVerdict::kNoReturns ? Reason::kNoReturns : Reason::kContradicted);
  }
  if (accepted && tracker.position_sigma_m() > kMaxPositionSigma) {
    restart_submap(Withdrawal::kScansLost);
    reason = Reason::kFewEvidence;
  }
  if (!accepted || !(news || search.is_suspended())) return;
  const double reviewed_m = distance_since_acceptance_m - searched_at_m;
  if (!confirmed) {
    review_acceptance(reviewed_m >= kReviewDistance);
  } else if (reviewed_m >= kConfirmedReviewDistance) {
    search.clear_candidates();
    review_again(/*is_search_due=*/false);
  }
  if (accepted && confirmed) submap.stop_gathering_evidence();
}

void Localizer::Impl::review_acceptance(bool is_search_due) {
  const LocalizationMap& map = *maps[accepted->map];
  const NewGround::Verdict verdict =
      new_ground.judge(map.index().classes, submap.evidence(), T_map_submap);
  // Either the pose was wrong or the robot was carried, which the local map does not survive.
  // After the confirmation the tracker judges scan by scan, since the local map bends with its
  // drift.
  if (verdict == NewGround::Verdict::kContradicts) return restart_submap(Withdrawal::kContradicted);
  if (!review_again(is_search_due)) return;
  if (searched && distance_since_acceptance_m >= kConfirmDistance &&
      verdict == NewGround::Verdict::kAgrees && search.acceptable()) {
    confirmed = true;
    search.clear_candidates();
    new_ground = {};
    release_other_maps();
  }
}

bool Localizer::Impl::review_again(bool is_search_due) {
  if (is_search_due || confirmed) searched_at_m = distance_since_acceptance_m;
  const View view = view_from(submap, T_submap_base_link);
  if (source && is_search_due && !search.is_suspended()) select_from_source(view);
  searched = search.review(maps, view, *accepted, is_search_due);
  if (search.is_suspended()) return false;
  const Candidates& candidates = search.candidates();
  const Candidate& best = candidates.best();
  if (best.map != accepted->map ||
      !is_same_place(best.T_map_base_link, accepted->T_map_base_link)) {
    if (search.acceptable()) {
      withdraw(Withdrawal::kRival);
      return false;
    }
    terms = {};
    confidence = 0.0;
    return false;
  }
  accepted->score = best.score;
  terms = search.terms();
  confidence = terms.probability_correct;
  return true;
}

void Localizer::Impl::miss(Reason why) {
  ++misfits;
  if (misfits <= kMaxMisfits && (misfit_way_m <= kMaxMisfitWay || misfits < kMinMisfits)) return;
  restart_submap(why == Reason::kContradicted ? Withdrawal::kContradicted : Withdrawal::kScansLost);
  reason = why;
}

void Localizer::Impl::withdraw(Withdrawal cause) {
  accepted.reset();
  submap.gather_evidence();
  search.lift_restriction();
  region.reset();
  withdrawal = cause;
  status = Status::kLost;
  reason = Reason::kContradicted;
  terms = {};
  confidence = 0.0;
}

}  // namespace cornerfix
