#include <cornerfix/localizer.hpp>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "core/src/acceptance/new_ground.hpp"
#include "core/src/local_map/scan_motion.hpp"
#include "core/src/search/global_search.hpp"
#include "core/src/search/map_index.hpp"
#include "core/src/search/same_place.hpp"
#include "core/src/tracking/odometry_monitor.hpp"
#include "core/src/tracking/pose_tracker.hpp"

namespace cornerfix {
namespace {

// Matching a scan to the submap.
constexpr double kMinUsualShare = 0.6;  // a scan that matches so much worse than usual strays
constexpr double kUsualGain = 0.1;      // by which a scan changes what is usual

// By which a match from constant velocity must beat that from odometry [share of the points].
constexpr double kClearlyBetterShare = 0.05;
constexpr std::size_t kEnoughPoints = 30;  // of a scan that may overrule odometry

// Scans that were lost make an interval this many times longer; more are a pause.
constexpr double kMaxIntervalRatio = 3.0;
// Odometry that does not change while the robot moved by this much from scan to scan may hang.
constexpr double kLeastMotion = 0.02;  // [m]
constexpr double kLeastTurn = 0.02;    // [rad]
// Odometry that differs from constant velocity by more has jumped: no wheeled robot accelerates so.
constexpr double kJump = 0.6;               // [m]
constexpr double kAcceleration = 5.0;       // [m/s^2]
constexpr double kTurnJump = 0.8;           // [rad]
constexpr double kTurnAcceleration = 20.0;  // [rad/s^2]

// Reviews of an accepted pose.
constexpr double kReviewDistance = 1.5;  // [m] between searches of the whole map
// Between reviews of a confirmed pose [m]: the local map then holds other scans (window_m).
constexpr double kConfirmedReviewDistance = 20.0;
constexpr double kConfirmDistance = 3.0;  // [m] after the acceptance

constexpr std::size_t kMaxLasers = 16;  // whose last scans are remembered

constexpr int kMaxStillScans = 10;  // without anything new: say that driving on would help

// Withdrawal of a pose.
constexpr double kMaxMisfitWay = 1.5;  // driven while the scans do not fit [m],
constexpr int kMinMisfits = 2;         // by at least so many scans;
constexpr int kMaxMisfits = 20;        // or so many scans, when standing

/// Rotates a matrix of x, y, yaw from the axes of the submap to those of base_link.
Eigen::Matrix3d in_base_link(const Eigen::Matrix3d& matrix, double yaw) {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(yaw).toRotationMatrix();
  return rotation.transpose() * matrix * rotation;
}

/// The part of a matched pose's covariance that its prediction causes: all of it in directions that
/// the scan does not constrain. `match` is along the axes of base_link, the others along those of
/// the submap.
Eigen::Matrix3d share_of_prior(const Eigen::Matrix3d& prior, const Eigen::Matrix3d& match,
                               double yaw) {
  const Eigen::Matrix3d covariance = (prior + in_base_link(match, -yaw)).inverse();
  return covariance * prior * covariance;
}

bool is_jump(const Pose2& odometry, const Pose2& steady_motion, double interval_s) {
  const double squared_s = interval_s * interval_s;
  return distance(odometry, steady_motion) > kJump + kAcceleration * squared_s ||
         angle_between(odometry, steady_motion) > kTurnJump + kTurnAcceleration * squared_s;
}

bool is_moving(const Pose2& motion) {
  return motion.translation().norm() > kLeastMotion || std::abs(motion.yaw) > kLeastTurn;
}

}  // namespace

struct Localizer::Impl {
  /// When a laser took its last scan, and where the robot was then.
  struct LaserMoment {
    Pose2 T_base_link_laser;
    double stamp = 0.0;  ///< [s]
    Pose2 T_submap_base_link;
  };

  Impl(std::vector<LocalizationMapPtr> the_maps, LocalizerParams the_params, Clock the_clock)
      : maps(std::move(the_maps)), params(the_params), clock(std::move(the_clock)) {}

  std::vector<LocalizationMapPtr> maps;
  LocalizerParams params;
  Clock clock;

  Submap submap;
  std::uint64_t scans = 0;
  Pose2 T_submap_base_link;
  Pose2 last_motion;
  double last_interval_s = 0.0;
  std::optional<double> last_stamp;
  std::optional<Pose2> last_T_odom_base_link;
  std::vector<LaserMoment> lasers;  ///< The last scan of each laser.
  int stray_scans = 0;
  std::optional<double> usual_share;  ///< Of a scan's points that match the submap.
  int still_scans = 0;                ///< In a row that showed nothing new.
  GlobalSearch search{params};
  std::optional<StartRegion> region;  ///< While it restricts the search.
  bool searched = false;              ///< At this scan.
  OdometryMonitor odometry_monitor;

  Status status = Status::kCollecting;
  Reason reason = Reason::kFewFeatures;
  double confidence = 0.0;
  AcceptanceTerms terms;  ///< Of the last decision.

  std::optional<Candidate> fix;  ///< While localized.
  PoseTracker tracker;           ///< Of the accepted pose.
  Pose2 T_map_submap;            ///< By the accepted pose.
  double misfit_way_m = 0.0;
  int misfits = 0;
  bool is_doubted = false;                    ///< This scan fits neither the local map nor the map.
  Withdrawal withdrawal = Withdrawal::kNone;  ///< At this scan.
  std::uint64_t epoch = 0;
  bool confirmed = false;
  double distance_since_acceptance_m = 0.0;
  double searched_at_m = 0.0;  ///< distance_since_acceptance_m at the last review of all poses.
  std::uint64_t accepted_index = 0;  ///< Of the first submap scan after the acceptance.
  NewGround new_ground;              ///< Since the acceptance.

  // --- one scan

  [[nodiscard]] double now() const { return clock ? clock() : 0.0; }

  Answer process(const RobotScan& robot_scan) {
    assert(!last_stamp || robot_scan.scan.stamp >= *last_stamp);
    StepTimes times;
    const double begin = now();
    searched = false;
    is_doubted = false;
    withdrawal = Withdrawal::kNone;
    const std::vector<Point2> points =
        points_to_match(robot_scan.scan, robot_scan.T_base_link_laser);
    move_along(robot_scan, points);
    times.odometry_ms = now() - begin;

    const double extract_begin = now();
    const bool news =
        !points.empty() && submap.wants(T_submap_base_link, robot_scan.T_base_link_laser);
    if (news) keep(robot_scan);
    still_scans = news ? 0 : still_scans + 1;
    times.extract_ms = now() - extract_begin;

    if (fix) {
      const double track_begin = now();
      track(robot_scan, points, news);
      times.track_ms = now() - track_begin;
    } else if (news || search.is_suspended()) {
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

  /// Scan-to-submap matching. Odometry predicts the motion as far as it agrees with the scans, the
  /// motion before where it does not.
  void move_along(const RobotScan& robot_scan, const std::vector<Point2>& points) {
    const Pose2 before = T_submap_base_link;
    const double stamp_before = last_stamp.value_or(robot_scan.scan.stamp);
    const Prediction prediction = predict(robot_scan);
    const Pose2& T_base_link_laser = robot_scan.T_base_link_laser;
    const LaserMoment last_moment{T_base_link_laser, stamp_before, before};
    // This scan begins the submap, wherever it is.
    if (submap.empty()) return note_velocity(last_moment);
    Pose2 now_at = prediction.likely.T_frame_base_link;
    Eigen::Matrix3d noise = prediction.likely.information.inverse();
    if (!points.empty()) {
      const Match matched = match(points, prediction);
      const bool is_new_laser = !submap.knows_laser(T_base_link_laser);
      if (belongs_to_submap(matched.pose.inlier_share, is_new_laser)) {
        now_at = matched.pose.T_frame_base_link;
        stray_scans = 0;
        const Eigen::Matrix3d information = submap.match_information(points, now_at);
        noise = share_of_prior(matched.prior_information, information, now_at.yaw);
        if (prediction.odometry)
          odometry_monitor.add(*prediction.odometry, inverse(before) * now_at, information);
      } else if (!is_new_laser && ++stray_scans >= kMaxStrayScans) {
        restart_submap(Withdrawal::kScansLost);
        return;
      }
    }
    T_submap_base_link = now_at;
    note_velocity(last_moment);
    const Pose2 motion = inverse(before) * now_at;
    const double step = distance(before, now_at);
    search.move_along(motion);
    if (fix) {
      misfit_way_m += step;
      distance_since_acceptance_m += step;
      tracker.predict(motion, in_base_link(noise, now_at.yaw));
    }
  }

  /// What is known of the pose at a scan before it is matched.
  struct Prediction {
    PosePrior likely;
    /// The other one of odometry and constant velocity; none while odometry is ignored.
    std::optional<PosePrior> alternative;
    bool is_odometry_likely = false;
    std::optional<Pose2> odometry;  ///< Motion since the last scan.
  };

  [[nodiscard]] Prediction predict(const RobotScan& robot_scan) {
    const std::optional<Pose2> T_odom_before =
        std::exchange(last_T_odom_base_link, robot_scan.T_odom_base_link);
    const double interval_s = last_stamp ? robot_scan.scan.stamp - *last_stamp : 0.0;
    const Pose2 steady_motion = motion_at_constant_velocity(interval_s);
    last_stamp = robot_scan.scan.stamp;
    const PosePrior steady = constant_velocity_prior(T_submap_base_link, steady_motion);
    if (!T_odom_before || !last_T_odom_base_link) return {steady, {}, false, {}};

    const Pose2 odometry = inverse(*T_odom_before) * *last_T_odom_base_link;
    if (odometry_monitor.use() == OdometryUse::kIgnored) return {steady, {}, false, odometry};
    const PosePrior by_odometry =
        odometry_prior(T_submap_base_link, odometry, odometry_monitor.noise_scale());
    const bool may_hang = *T_odom_before == *last_T_odom_base_link && is_moving(steady_motion);
    if (may_hang || is_jump(odometry, steady_motion, interval_s))
      return {steady, by_odometry, false, odometry};
    return {by_odometry, steady, true, odometry};
  }

  /// The motion until the next scan, `interval_s` after the last.
  [[nodiscard]] Pose2 motion_at_constant_velocity(double interval_s) const {
    if (last_interval_s <= 0.0) return last_motion;
    const double ratio = std::min(kMaxIntervalRatio, interval_s / last_interval_s);
    return {ratio * last_motion.x, ratio * last_motion.y, wrap_angle(ratio * last_motion.yaw)};
  }

  struct Match {
    RefinedPose pose;
    Eigen::Matrix3d prior_information;  ///< Of the prediction that it started from.
  };

  /// Lays a scan on the submap from the likely prediction, and from the alternative where that
  /// leads to no match or odometry is implausible.
  [[nodiscard]] Match match(const std::vector<Point2>& points, const Prediction& prediction) const {
    const Match likely{submap.match(points, prediction.likely), prediction.likely.information};
    const bool is_enough =
        prediction.is_odometry_likely && likely.pose.inlier_share >= least_matched_share();
    if (is_enough || !prediction.alternative || points.size() < kEnoughPoints) return likely;
    const Match other{submap.match(points, *prediction.alternative),
                      prediction.alternative->information};
    return other.pose.inlier_share > likely.pose.inlier_share + kClearlyBetterShare ? other
                                                                                    : likely;
  }

  [[nodiscard]] double least_matched_share() const {
    return std::max(kMinMatchedShare, kMinUsualShare * usual_share.value_or(0.0));
  }

  /// The velocity is that since the last scan of the same laser, because scans of two lasers may
  /// be too near in time. `last_moment` is that of the last scan of any.
  void note_velocity(LaserMoment last_moment) {
    const auto known = std::ranges::find_if(lasers, [&](const LaserMoment& one) {
      return is_same_laser(one.T_base_link_laser, last_moment.T_base_link_laser);
    });
    if (known != lasers.end()) {
      last_moment = *known;
      lasers.erase(known);
    }
    const double interval_s = *last_stamp - last_moment.stamp;
    if (interval_s > 0.0) {
      last_motion = inverse(last_moment.T_submap_base_link) * T_submap_base_link;
      last_interval_s = interval_s;
    }
    if (lasers.size() == kMaxLasers) lasers.erase(lasers.begin());
    lasers.push_back({last_moment.T_base_link_laser, *last_stamp, T_submap_base_link});
  }

  bool belongs_to_submap(double matched_share, bool is_new_laser) {
    // What the first scan of a laser shows, no other may have seen.
    if (is_new_laser) return matched_share >= kMinMatchedShare;
    const double usual = usual_share.value_or(matched_share);
    usual_share = usual + kUsualGain * (matched_share - usual);
    return matched_share >= std::max(kMinMatchedShare, kMinUsualShare * usual);
  }

  /// The scans no longer continue the submap: all that was derived from it is void.
  void restart_submap(Withdrawal cause) {
    submap = Submap();
    T_submap_base_link = {};
    last_motion = {};
    lasers.clear();
    stray_scans = 0;
    usual_share.reset();
    search.reset();
    region.reset();
    new_ground = {};
    if (fix) withdraw(cause);
    terms = {};
    confidence = 0.0;
  }

  /// The pose is no longer an answer; the submap and the search go on.
  void withdraw(Withdrawal cause) {
    fix.reset();
    submap.gather_evidence();
    search.lift_restriction();
    region.reset();
    withdrawal = cause;
    status = Status::kLost;
    reason = Reason::kContradicted;
    terms = {};
    confidence = 0.0;
  }

  void keep(const RobotScan& robot_scan) {
    SubmapScan kept{0, robot_scan.scan, robot_scan.T_base_link_laser, T_submap_base_link};
    submap.keep(std::move(kept), corners_of(robot_scan.scan));
  }

  [[nodiscard]] std::vector<Feature> corners_of(const LaserScan& scan) const {
    return extract_corners(scan, params.extractor);
  }

  // --- search

  void restrict_to(std::optional<StartRegion> start_region) {
    region = std::move(start_region);
    if (region) search.restrict_to(*region, T_submap_base_link);
  }

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
          submap.features().size() < static_cast<std::size_t>(params.min_features);
      reason = few_features ? Reason::kFewFeatures : no_match();
      if (search.only_mirror_image_fits()) reason = Reason::kMirroredScans;
      return;
    }
    terms = search.terms();
    confidence = terms.probability_correct;
    if (!search.acceptable()) {
      reason = candidates.missing_without_rivals();
      const bool fits_badly = reason == Reason::kNoMatch || reason == Reason::kContradicted;
      if (reason == Reason::kNoMatch || (region && fits_badly)) reason = no_match();
      if (reason != Reason::kNone && search.only_mirror_image_fits())
        reason = Reason::kMirroredScans;
      if (reason == Reason::kNone && !was_lost) status = Status::kAmbiguous;
      return;
    }
    if (search.mirror_image_fits_better(maps, view)) {
      reason = Reason::kFewEvidence;
      return;
    }
    // A pose that new ground contradicted is not accepted again by what was seen before.
    const Candidate& best = candidates.best();
    const NewGround::Verdict verdict =
        new_ground.judge(maps[best.map]->index().classes, submap.evidence(),
                         best.T_map_base_link * inverse(T_submap_base_link));
    if (verdict == NewGround::Verdict::kContradicts) {
      reason = Reason::kContradicted;
      return;
    }
    accept(candidates.best());
  }

  [[nodiscard]] Reason no_match() const {
    return region ? Reason::kPriorContradicted : Reason::kNoMatch;
  }

  void accept(const Candidate& best) {
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

  // --- tracking

  void begin_tracking(const Candidate& candidate) {
    fix = candidate;
    tracker = PoseTracker(candidate.T_map_base_link);
    T_map_submap = candidate.T_map_base_link * inverse(T_submap_base_link);
  }

  /// Corrects the pose by the scan and withdraws it when scans contradict the map.
  void track(const RobotScan& robot_scan, const std::vector<Point2>& points, bool news) {
    const LocalizationMap& map = *maps[fix->map];
    const TrackingVerdict verdict =
        tracker.update(map, points, robot_scan.T_base_link_laser.translation());
    fix->T_map_base_link = tracker.T_map_base_link();
    T_map_submap = fix->T_map_base_link * inverse(T_submap_base_link);
    if (verdict == TrackingVerdict::kFits) {
      misfits = 0;
      misfit_way_m = 0.0;
    } else {
      is_doubted = verdict == TrackingVerdict::kMisfits && stray_scans > 0;
      miss(verdict == TrackingVerdict::kNoReturns ? Reason::kNoReturns : Reason::kContradicted);
    }
    if (!fix || !(news || search.is_suspended())) return;
    const double reviewed_m = distance_since_acceptance_m - searched_at_m;
    if (!confirmed) {
      review_acceptance(reviewed_m >= kReviewDistance);
    } else if (reviewed_m >= kConfirmedReviewDistance) {
      search.clear_candidates();
      review_again(/*is_search_due=*/false);
    }
    if (fix && confirmed) submap.stop_gathering_evidence();
  }

  /// Judges new ground, then repeats the decision with what was seen since the acceptance.
  void review_acceptance(bool is_search_due) {
    const LocalizationMap& map = *maps[fix->map];
    const NewGround::Verdict verdict =
        new_ground.judge(map.index().classes, submap.evidence(), T_map_submap);
    // Either the pose was wrong or the robot was carried, which the local map does not survive.
    // After the confirmation the tracker judges scan by scan, since the local map bends with its
    // drift.
    if (verdict == NewGround::Verdict::kContradicts)
      return restart_submap(Withdrawal::kContradicted);
    if (!review_again(is_search_due)) return;
    if (searched && distance_since_acceptance_m >= kConfirmDistance &&
        verdict == NewGround::Verdict::kAgrees && search.acceptable()) {
      confirmed = true;
      search.clear_candidates();
      new_ground = {};
    }
  }

  /// Repeats the decision. Returns whether the pose is still the best one.
  bool review_again(bool is_search_due) {
    if (is_search_due || confirmed) searched_at_m = distance_since_acceptance_m;
    const View view = view_from(submap, T_submap_base_link);
    searched = search.review(maps, view, *fix, is_search_due);
    if (search.is_suspended()) return false;
    const Candidates& candidates = search.candidates();
    const Candidate& best = candidates.best();
    if (best.map != fix->map || !is_same_place(best.T_map_base_link, fix->T_map_base_link)) {
      if (search.acceptable()) {
        withdraw(Withdrawal::kRival);
        return false;
      }
      terms = {};
      confidence = 0.0;
      return false;
    }
    fix->score = best.score;
    terms = search.terms();
    confidence = terms.probability_correct;
    return true;
  }

  /// A scan that does not confirm the pose; too many in a row take it back.
  void miss(Reason why) {
    ++misfits;
    if (misfits <= kMaxMisfits && (misfit_way_m <= kMaxMisfitWay || misfits < kMinMisfits)) return;
    restart_submap(why == Reason::kContradicted ? Withdrawal::kContradicted
                                                : Withdrawal::kScansLost);
    reason = why;
  }

  // --- answer

  [[nodiscard]] Answer answer(const StepTimes& times) const {
    Answer answer;
    answer.status = is_doubted && fix ? Status::kLost : status;
    answer.odometry = last_T_odom_base_link ? odometry_monitor.use() : OdometryUse::kNone;
    answer.withdrawal = withdrawal;
    answer.terms = terms;
    answer.is_given_region = region.has_value();
    answer.searched = searched;
    answer.reason = answer.status == Status::kLocalized ? Reason::kNone : reason;
    if (is_doubted && fix) answer.reason = Reason::kContradicted;
    if (answer.reason == Reason::kContradicted && answer.odometry == OdometryUse::kIgnored)
      answer.reason = Reason::kOdometryContradictsScans;
    if (answer.status == Status::kLocalized || !fix) answer.confidence = confidence;
    if (fix && is_doubted) {
      answer.hypotheses.push_back(ranked(*fix));
    } else if (fix) {
      LocalizedPose pose{maps[fix->map], tracker.T_map_base_link(), {}, epoch, confirmed};
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

void Localizer::reset(std::optional<StartRegion> region) {
  assert(!region || !validate(*region));
  const std::uint64_t epoch = impl_->epoch;
  const OdometryMonitor odometry_monitor = impl_->odometry_monitor;
  *impl_ = Impl(std::move(impl_->maps), impl_->params, std::move(impl_->clock));
  impl_->epoch = epoch;
  impl_->odometry_monitor = odometry_monitor;
  impl_->restrict_to(std::move(region));
}

const std::optional<StartRegion>& Localizer::region() const { return impl_->region; }

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
  state.last_interval_s = impl_->last_interval_s;
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
  state.odometry_sums = impl_->odometry_monitor.sums();
  state.epoch = impl_->epoch;
  state.confirmed = impl_->confirmed;
  state.distance_since_acceptance_m = impl_->distance_since_acceptance_m;
  state.searched_at_m = impl_->searched_at_m;
  state.accepted_index = impl_->accepted_index;
  state.region = impl_->region;
  return state;
}

void Localizer::restore(LocalizerState state) {
  reset();
  std::optional<Evidence> old_ground;  ///< Of the scans until the acceptance.
  for (SubmapScan& scan : state.submap) {
    if (!old_ground && scan.index >= state.accepted_index) old_ground = impl_->submap.evidence();
    std::vector<Feature> corners = impl_->corners_of(scan.scan);
    impl_->submap.keep(std::move(scan), std::move(corners), true);
  }
  impl_->submap.set_next_index(state.next_index);
  impl_->scans = state.scans;
  impl_->T_submap_base_link = state.T_submap_base_link;
  impl_->last_motion = state.last_motion;
  impl_->last_interval_s = state.last_interval_s;
  impl_->last_stamp = state.last_stamp;
  impl_->last_T_odom_base_link = state.last_T_odom_base_link;
  impl_->status = state.status;
  impl_->reason = state.reason;
  impl_->confidence = state.confidence;
  impl_->misfits = state.misfits;
  impl_->misfit_way_m = state.misfit_way_m;
  impl_->usual_share = state.usual_share;
  impl_->odometry_monitor = OdometryMonitor(state.odometry_sums);
  impl_->epoch = state.epoch;
  impl_->confirmed = state.confirmed;
  impl_->distance_since_acceptance_m = state.distance_since_acceptance_m;
  impl_->searched_at_m = state.searched_at_m;
  impl_->accepted_index = state.accepted_index;
  impl_->restrict_to(std::move(state.region));
  if (state.tracked_map >= 0)
    impl_->new_ground = NewGround(old_ground.value_or(impl_->submap.evidence()));
  if (state.tracked_map >= 0 && static_cast<std::size_t>(state.tracked_map) < impl_->maps.size()) {
    Candidate fix{static_cast<std::size_t>(state.tracked_map),
                  state.T_map_submap * state.T_submap_base_link,
                  0,
                  0,
                  {}};
    fix.score = score_evidence(impl_->maps[fix.map]->index().classes, impl_->submap.evidence(),
                               state.T_map_submap);
    impl_->begin_tracking(fix);
    if (state.confirmed) impl_->submap.stop_gathering_evidence();
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
