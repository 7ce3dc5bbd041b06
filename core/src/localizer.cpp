#include <cornerfix/localizer.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "global_search.hpp"
#include "pose_tracker.hpp"
#include "scan_motion.hpp"

namespace cornerfix {
namespace {

// Matching a scan to the submap.
constexpr double kMinUsualShare = 0.6;  // a scan that matches so much worse than usual strays
constexpr double kUsualGain = 0.1;      // by which a scan changes what is usual

constexpr int kMaxStillScans = 10;  // without anything new: say that driving on would help

// Taking a pose back.
constexpr double kMaxMisfitWay = 1.5;  // driven while the scans do not fit [m],
constexpr int kMinMisfits = 2;         // as told by so many scans at least;
constexpr int kMaxMisfits = 20;        // or so many scans, when standing

}  // namespace

std::string_view to_string(Status status) {
  switch (status) {
    case Status::kCollecting:
      return "collecting";
    case Status::kAmbiguous:
      return "ambiguous";
    case Status::kLocalized:
      return "localized";
    case Status::kLost:
      return "lost";
  }
  return "collecting";
}

std::string_view to_string(Reason reason) {
  switch (reason) {
    case Reason::kNone:
      return "";
    case Reason::kNoReturns:
      return "no_returns";
    case Reason::kFewFeatures:
      return "few_features";
    case Reason::kNoMotion:
      return "no_motion";
    case Reason::kNoMatch:
      return "no_match";
    case Reason::kFewEvidence:
      return "few_evidence";
    case Reason::kContradicted:
      return "contradicted";
  }
  return "";
}

struct Localizer::Impl {
  Impl(std::vector<LocalizationMapPtr> the_maps, LocalizerParams the_params, Clock the_clock)
      : maps(std::move(the_maps)), params(the_params), clock(std::move(the_clock)) {}

  std::vector<LocalizationMapPtr> maps;
  LocalizerParams params;
  Clock clock;

  Submap submap;
  std::uint64_t scans = 0;
  Pose2 T_submap_base_link;
  Pose2 last_motion;
  double way_m = 0.0;
  std::optional<double> last_stamp;
  std::optional<Pose2> last_T_odom_base_link;
  int stray_scans = 0;
  std::optional<double> usual_share;  ///< Of a scan's points that match the submap.
  int still_scans = 0;                ///< In a row that showed nothing new.
  GlobalSearch search{params};
  bool searched = false;  ///< At this scan.

  Status status = Status::kCollecting;
  Reason reason = Reason::kFewFeatures;
  double confidence = 0.0;

  std::optional<Candidate> fix;  ///< While localized.
  PoseTracker tracker;           ///< Of the fix.
  Pose2 T_map_submap;            ///< By the fix.
  double misfit_way_m = 0.0;
  int misfits = 0;

  // --- one scan
  // ---------------------------------------------------------------------------------------------------

  [[nodiscard]] double now() const { return clock ? clock() : 0.0; }

  Answer process(const RobotScan& robot_scan) {
    assert(!last_stamp || robot_scan.scan.stamp > *last_stamp);
    StepTimes times;
    const double begin = now();
    searched = false;
    const std::vector<Point2> points =
        points_to_match(robot_scan.scan, robot_scan.T_base_link_laser);
    move_along(robot_scan, points);
    times.odometry_ms = now() - begin;

    const double extract_begin = now();
    const bool news = !points.empty() && submap.wants(T_submap_base_link);
    if (news) keep(robot_scan);
    still_scans = news ? 0 : still_scans + 1;
    times.extract_ms = now() - extract_begin;

    if (fix) {
      const double track_begin = now();
      track(robot_scan, points, news);
      times.track_ms = now() - track_begin;
    } else if (news) {
      look_for_robot(times);
      if (fix) track(robot_scan, points, false);
    } else if (submap.empty()) {
      reason = Reason::kNoReturns;
    } else if (still_scans >= kMaxStillScans && status == Status::kCollecting) {
      reason = Reason::kNoMotion;
    }
    ++scans;
    times.total_ms = now() - begin;
    return answer(times);
  }

  /// Scan-to-submap matching, from odometry where it is there and constant velocity where it is
  /// not.
  void move_along(const RobotScan& robot_scan, const std::vector<Point2>& points) {
    const bool has_odometry = robot_scan.T_odom_base_link && last_T_odom_base_link;
    const Pose2 motion =
        has_odometry ? inverse(*last_T_odom_base_link) * *robot_scan.T_odom_base_link : last_motion;
    last_T_odom_base_link = robot_scan.T_odom_base_link;
    last_stamp = robot_scan.scan.stamp;
    if (submap.empty()) return;  // this scan begins the submap, wherever it is
    const Pose2 before = T_submap_base_link;
    Pose2 now_at = before * motion;
    if (!points.empty()) {
      const RefinedPose matched = submap.match(points, motion_prior(now_at, motion, has_odometry));
      if (belongs_to_submap(matched.inlier_share)) {
        now_at = matched.T_frame_base_link;
        stray_scans = 0;
      } else if (++stray_scans >= kMaxStrayScans) {
        restart_submap();
        return;
      }
    }
    T_submap_base_link = now_at;
    last_motion = inverse(before) * now_at;
    const double step = distance(before, now_at);
    way_m += step;
    search.move_along(last_motion);
    if (fix) {
      misfit_way_m += step;
      tracker.predict(last_motion, stray_scans == 0);
    }
  }

  bool belongs_to_submap(double matched_share) {
    const double usual = usual_share.value_or(matched_share);
    usual_share = usual + kUsualGain * (matched_share - usual);
    return matched_share >= std::max(kMinMatchedShare, kMinUsualShare * usual);
  }

  /// The scans no longer continue the submap: whatever was known from it is void.
  void restart_submap() {
    submap = Submap();
    T_submap_base_link = {};
    last_motion = {};
    stray_scans = 0;
    usual_share.reset();
    search.reset();
    confidence = 0.0;
    if (fix) {
      fix.reset();
      status = Status::kLost;
      reason = Reason::kContradicted;
    }
  }

  void keep(const RobotScan& robot_scan) {
    SubmapScan kept{0, robot_scan.scan, robot_scan.T_base_link_laser, T_submap_base_link};
    submap.keep(std::move(kept), corners_of(robot_scan.scan));
  }

  [[nodiscard]] std::vector<Feature> corners_of(const LaserScan& scan) const {
    return extract_corners(scan, params.extractor);
  }

  // --- search
  // -----------------------------------------------------------------------------------------------------

  void look_for_robot(StepTimes& times) {
    const View view = view_from(submap, T_submap_base_link);
    const double match_begin = now();
    search.propose(maps, view, params.seed + scans);
    times.match_ms = now() - match_begin;

    const double verify_begin = now();
    search.verify(maps, view);
    searched = search.searched();
    decide(view);
    times.verify_ms = now() - verify_begin;
  }

  void decide(const View& view) {
    const bool was_lost = status == Status::kLost;
    status = was_lost ? Status::kLost : Status::kCollecting;
    confidence = 0.0;
    const Candidates& candidates = search.candidates();
    if (candidates.empty()) {
      const bool few_features =
          params.method != Method::kIndexed &&
          submap.features().size() < static_cast<std::size_t>(params.min_features);
      reason = few_features ? Reason::kFewFeatures : Reason::kNoMatch;
      return;
    }
    confidence = probability_right(candidates.best().score, search.gap());
    if (!candidates.acceptable(search.gap())) {
      reason = candidates.missing_without_rivals();
      if (reason == Reason::kNone && !was_lost) status = Status::kAmbiguous;
      return;
    }
    if (search.mirror_image_fits_better(maps, view)) {
      reason = Reason::kFewEvidence;
      return;
    }
    status = Status::kLocalized;
    reason = Reason::kNone;
    begin_tracking(candidates.best());
    misfits = 0;
    misfit_way_m = 0.0;
  }

  // --- tracking
  // ---------------------------------------------------------------------------------------------------

  void begin_tracking(const Candidate& candidate) {
    fix = candidate;
    tracker = PoseTracker(candidate.T_map_base_link);
    T_map_submap = candidate.T_map_base_link * inverse(T_submap_base_link);
  }

  /// Corrects the pose by the scan; takes it back when scans stay off the walls.
  void track(const RobotScan& robot_scan, const std::vector<Point2>& points, bool news) {
    const LocalizationMap& map = *maps[fix->map];
    const TrackingVerdict verdict =
        tracker.update(map, points, robot_scan.T_base_link_laser.translation());
    fix->T_map_base_link = tracker.T_map_base_link();
    T_map_submap = fix->T_map_base_link * inverse(T_submap_base_link);
    if (news) fix->score = score_evidence(map.classes(), submap.evidence(), T_map_submap);
    if (verdict != TrackingVerdict::kFits) {
      miss(verdict == TrackingVerdict::kNoReturns ? Reason::kNoReturns : Reason::kContradicted);
      return;
    }
    misfits = 0;
    misfit_way_m = 0.0;
  }

  /// A scan that does not confirm the pose; too many in a row take it back.
  void miss(Reason why) {
    ++misfits;
    if (misfits <= kMaxMisfits && (misfit_way_m <= kMaxMisfitWay || misfits < kMinMisfits)) return;
    restart_submap();
    reason = why;
  }

  // --- answer
  // -----------------------------------------------------------------------------------------------------

  [[nodiscard]] Answer answer(const StepTimes& times) const {
    Answer answer;
    answer.status = status;
    answer.reason = status == Status::kLocalized ? Reason::kNone : reason;
    answer.confidence = confidence;
    answer.searched = searched;
    if (fix) {
      LocalizedPose pose{maps[fix->map], tracker.T_map_base_link(), {}};
      const Eigen::Matrix3d covariance = tracker.covariance();
      std::copy_n(covariance.data(), 9, pose.covariance.begin());  // symmetric: any order will do
      answer.pose = pose;
      answer.hypotheses.push_back(ranked(*fix));
    } else {
      for (const Candidate& candidate : search.candidates().all())
        answer.hypotheses.push_back(ranked(candidate));
    }
    answer.local_scans = static_cast<int>(submap.size());
    answer.local_features = static_cast<int>(submap.features().size());
    answer.T_submap_base_link = T_submap_base_link;
    answer.times = times;
    return answer;
  }

  [[nodiscard]] RankedHypothesis ranked(const Candidate& candidate) const {
    return {maps[candidate.map], candidate.T_map_base_link, candidate.votes,
            candidate.inliers,   candidate.score.matched,   candidate.score};
  }
};

Localizer::Localizer(std::vector<LocalizationMapPtr> maps, LocalizerParams params, Clock clock)
    : impl_(std::make_unique<Impl>(std::move(maps), params, std::move(clock))) {}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

Answer Localizer::process(const RobotScan& scan) { return impl_->process(scan); }

void Localizer::reset() {
  *impl_ = Impl(std::move(impl_->maps), impl_->params, std::move(impl_->clock));
}

void Localizer::replace_maps(std::vector<LocalizationMapPtr> maps) {
  assert(maps.size() >= impl_->maps.size() && "maps may join at the end, none may leave");
  impl_->maps = std::move(maps);
}

LocalizerState Localizer::state() const {
  LocalizerState state;
  state.submap = impl_->submap.scans();
  state.next_index = impl_->submap.next_index();
  state.scans = impl_->scans;
  state.T_submap_base_link = impl_->T_submap_base_link;
  state.last_motion = impl_->last_motion;
  state.way_m = impl_->way_m;
  state.last_stamp = impl_->last_stamp;
  state.last_T_odom_base_link = impl_->last_T_odom_base_link;
  state.status = impl_->status;
  state.reason = impl_->reason;
  state.confidence = impl_->confidence;
  if (impl_->fix) {
    state.tracked_map = static_cast<int>(impl_->fix->map);
    state.T_map_submap = impl_->T_map_submap;
    const Eigen::Matrix3d& covariance = impl_->tracker.filtered_covariance();
    std::copy_n(covariance.data(), 9, state.tracking_covariance.begin());
    state.usual_fit = impl_->tracker.usual_fit();
  }
  state.misfits = impl_->misfits;
  state.misfit_way_m = impl_->misfit_way_m;
  state.usual_share = impl_->usual_share;
  return state;
}

void Localizer::restore(LocalizerState state) {
  reset();
  for (SubmapScan& scan : state.submap) {
    std::vector<Feature> corners = impl_->corners_of(scan.scan);
    impl_->submap.keep(std::move(scan), std::move(corners), true);
  }
  impl_->submap.set_next_index(state.next_index);
  impl_->scans = state.scans;
  impl_->T_submap_base_link = state.T_submap_base_link;
  impl_->last_motion = state.last_motion;
  impl_->way_m = state.way_m;
  impl_->last_stamp = state.last_stamp;
  impl_->last_T_odom_base_link = state.last_T_odom_base_link;
  impl_->status = state.status;
  impl_->reason = state.reason;
  impl_->confidence = state.confidence;
  impl_->misfits = state.misfits;
  impl_->misfit_way_m = state.misfit_way_m;
  impl_->usual_share = state.usual_share;
  if (state.tracked_map >= 0 && static_cast<std::size_t>(state.tracked_map) < impl_->maps.size()) {
    Candidate fix{static_cast<std::size_t>(state.tracked_map),
                  state.T_map_submap * state.T_submap_base_link,
                  0,
                  0,
                  {}};
    fix.score = score_evidence(impl_->maps[fix.map]->classes(), impl_->submap.evidence(),
                               state.T_map_submap);
    impl_->begin_tracking(fix);
    impl_->T_map_submap = state.T_map_submap;
    const Eigen::Map<const Eigen::Matrix3d> covariance(state.tracking_covariance.data());
    if (covariance.trace() > 0.0) {
      impl_->tracker = PoseTracker(impl_->tracker.T_map_base_link(), covariance, state.usual_fit);
    }
  } else if (impl_->status == Status::kLocalized) {
    impl_->status = Status::kCollecting;
    impl_->reason = Reason::kNoMatch;
    impl_->confidence = 0.0;
  }
}

std::optional<double> Localizer::last_stamp() const { return impl_->last_stamp; }

const std::vector<LocalizationMapPtr>& Localizer::maps() const { return impl_->maps; }

std::vector<Point2> Localizer::local_features_base_link() const {
  const Pose2 T_base_link_submap = inverse(impl_->T_submap_base_link);
  std::vector<Point2> points;
  for (const Feature& feature : impl_->submap.features())
    points.push_back(T_base_link_submap * feature.position);
  return points;
}

}  // namespace cornerfix
