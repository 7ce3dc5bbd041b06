#include <cornerfix/localizer.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "pose_tracker.hpp"
#include "same_place.hpp"
#include "scan_motion.hpp"

namespace cornerfix {
namespace {

// Matching a scan to the submap.
constexpr double kMinUsualShare = 0.6;  // a scan that matches so much worse than usual strays
constexpr double kUsualGain = 0.1;      // by which a scan changes what is usual

constexpr int kMaxStillScans = 10;  // without anything new: say that driving on would help

// Candidates.
constexpr std::size_t kMaxCandidates = 12;
constexpr double kRivalMargin =
    0.75;  // mean log-likelihood below the best at which a rival cannot matter [nat]
constexpr double kSeedMargin = 0.15;   // the same when there will be no fix now: what may win later
constexpr double kSearchSlack = 0.05;  // by which the search may misjudge a place [nat]

// Taking a pose back.
constexpr double kMaxMisfitWay = 1.5;  // driven while the scans do not fit [m],
constexpr int kMinMisfits = 2;         // as told by so many scans at least;
constexpr int kMaxMisfits = 20;        // or so many scans, when standing

struct Candidate {
  std::size_t map = 0;
  Pose2 T_map_submap;
  int votes = 0;
  int inliers = 0;
  EvidenceScore score;
};

std::vector<Point2> transformed_points(const Pose2& T, const std::vector<Point2>& points) {
  std::vector<Point2> moved;
  moved.reserve(points.size());
  const double c = std::cos(T.yaw);
  const double s = std::sin(T.yaw);
  for (const Point2& p : points)
    moved.emplace_back(T.x + c * p.x() - s * p.y(), T.y + s * p.x() + c * p.y());
  return moved;
}

/// What was seen and where the robot has been, in base_link at the last scan.
struct View {
  Evidence evidence;
  std::vector<Point2> way;
};

View mirrored(View view) {
  for (std::vector<Point2>* points :
       {&view.evidence.ends, &view.evidence.free, &view.evidence.origins, &view.way}) {
    for (Point2& p : *points) p.y() = -p.y();
  }
  return view;
}

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
  bool searched = false;              ///< At this scan.
  std::size_t searched_ends = 0;      ///< Evidence at the last search of the whole map.
  double searched_way_m = 0.0;
  double rival_margin = kRivalMargin;  ///< Farther below the best, a beam end, none was looked for.

  Status status = Status::kCollecting;
  Reason reason = Reason::kFewFeatures;
  std::vector<Candidate> candidates;  ///< Best first.
  double confidence = 0.0;

  std::optional<Candidate> fix;  ///< While localized.
  PoseTracker tracker;           ///< Of the fix.
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
      search(times);
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
    searched_ends = 0;
    candidates.clear();
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

  void search(StepTimes& times) {
    const double match_begin = now();
    std::vector<Candidate> found = std::move(candidates);
    if (params.method != Method::kIndexed &&
        submap.features().size() >= static_cast<std::size_t>(params.min_features)) {
      for (std::size_t map = 0; map < maps.size(); ++map) match_features(map, found);
    }
    times.match_ms = now() - match_begin;

    const double verify_begin = now();
    rival_margin = kRivalMargin;
    const View seen = view();
    judge(seen, found);
    if (search_due()) {
      add_places(seen);
      // A place found late may be worth a deeper look than the maps before it were given.
      if (!candidates.empty() && may_be_fix() && rival_margin < margin_to_look_at())
        add_places(seen);
      searched = true;
      searched_ends = submap.evidence().ends.size();
      searched_way_m = way_m;
    }
    decide(seen);
    times.verify_ms = now() - verify_begin;
  }

  /// NMA or RMA, RANSAC on the pairs of the best matches (eqs. 15-18).
  void match_features(std::size_t map, std::vector<Candidate>& found) const {
    const std::vector<Feature>& features = submap.features();
    const DescriptorIndex& index = maps[map]->descriptor_index();
    const DescriptorSet local = describe(features, index.params());
    const auto max_matches = static_cast<std::size_t>(params.max_matches);
    SampledMatchParams sampling = params.sampling;
    sampling.seed = params.seed + scans;
    const std::vector<DescriptorMatch> matches =
        params.method == Method::kNma
            ? match_exhaustive(local, index, params.min_votes, max_matches)
            : match_sampled(local, index, params.min_votes, max_matches, sampling);
    for (const DescriptorMatch& match : matches) {
      std::vector<Correspondence> correspondences;
      const std::vector<Feature>& mapped = maps[map]->features();
      const auto global = describe_one(mapped, match.global_feature, index.params());
      for (const auto& [m, n] :
           pairs_of(match, local[match.local_feature], global, local.angle_bins())) {
        correspondences.push_back({features[m].position, mapped[n].position});
      }
      PoseEstimatorParams estimator = params.estimator;
      estimator.seed = params.seed;
      if (const auto estimate = estimate_pose(correspondences, estimator)) {
        found.push_back({map,
                         estimate->T_map_submap,
                         match.votes,
                         static_cast<int>(estimate->inliers.size()),
                         {}});
      }
    }
  }

  /// Whether the whole map must be looked at now.
  [[nodiscard]] bool search_due() const {
    // The gap to the second best means nothing while the second best may not have been looked at.
    if (!candidates.empty() && acceptable(gap())) return true;
    if (params.method != Method::kIndexed) return false;
    const double growth = static_cast<double>(submap.evidence().ends.size()) /
                          std::max(1.0, static_cast<double>(searched_ends));
    return searched_ends == 0 || growth >= 1.6 || way_m - searched_way_m >= 3.0;
  }

  /// Gap at which the best candidate would be a fix.
  [[nodiscard]] double needed_gap(double probability) const {
    const EvidenceScore& best = candidates.front().score;
    return std::max({gap_for(best, probability), params.acceptance.min_gap,
                     params.acceptance.min_mean_gap * best.ends});
  }

  /// How far below the best candidate, a beam end, a place may lie and still matter. Who asks for
  /// an endless gap wants to know all.
  [[nodiscard]] double margin_to_look_at() const {
    constexpr double kMoreThanSure = 0.998;
    if (candidates.empty()) return kRivalMargin;
    const double needed = needed_gap(kMoreThanSure) / std::max(1, candidates.front().score.ends);
    if (std::isfinite(needed) && !may_be_fix()) return kSeedMargin;
    return std::min(kRivalMargin, needed);
  }

  /// Whether the best candidate would be a fix if there were no other places than those known.
  [[nodiscard]] bool may_be_fix() const { return acceptable(gap_to_known(kRivalMargin)); }

  /// Looks in all maps for places that come near the best candidate, and which nears the best of
  /// them.
  void add_places(const View& view) {
    // What no map may fall far below, from one map to the next.
    double best_mean = kMinPlaceWeight + kRivalMargin;
    for (const Candidate& candidate : candidates)
      best_mean = std::max(best_mean, optimistic_mean(view, candidate));
    double looked_down_to = -std::numeric_limits<double>::infinity();
    for (std::size_t map = 0; map < maps.size(); ++map) {
      PlaceSearch::Run run(maps[map]->place_search(), view.evidence.ends, view.way, {});
      for (std::size_t places = 0; places < kMaxCandidates; ++places) {
        // What was passed over once stays so, even if a better place lowers the limit.
        looked_down_to = std::max(looked_down_to, best_mean - margin_to_look_at());
        const std::optional<Place> place = run.next(looked_down_to);
        if (!place) break;
        best_mean = std::max(best_mean, place->mean_weight);
        consider(view, {map, place->T_map_base_link * inverse(T_submap_base_link), 0, 0, {}});
      }
    }
    rival_margin = std::min(kRivalMargin, best_mean - looked_down_to);
  }

  /// What the search says of a candidate.
  [[nodiscard]] double optimistic_mean(const View& view, const Candidate& candidate) const {
    return maps[candidate.map]->place_search().mean_weight(
        view.evidence.ends, view.way, PlaceSearchParams{}.max_points,
        candidate.T_map_submap * T_submap_base_link);
  }

  /// Whether the best candidate's map holds the mirror image of what was seen, and better: then
  /// what was seen is symmetric, or the lidar is mounted upside down.
  [[nodiscard]] bool mirror_image_fits_better(const View& view) const {
    const Candidate& best = candidates.front();
    const LocalizationMap& map = *maps[best.map];
    const View image = mirrored(view);
    const PlaceSearchParams search{.min_mean_weight = optimistic_mean(view, best) - kSearchSlack,
                                   .max_mean_gap = kSearchSlack};
    const auto places = map.place_search().find(image.evidence.ends, image.way, search);
    return std::any_of(places.begin(), places.end(), [&](const Place& place) {
      const Pose2 T_map_base_link =
          refined_coarse_to_fine(map.field(), image.evidence.ends, place.T_map_base_link);
      return score_evidence(map.classes(), image.evidence, T_map_base_link).fit >= best.score.fit;
    });
  }

  [[nodiscard]] View view() const {
    const Pose2 T_base_link_submap = inverse(T_submap_base_link);
    const Evidence& seen = submap.evidence();
    View view{{transformed_points(T_base_link_submap, seen.ends),
               transformed_points(T_base_link_submap, seen.free),
               transformed_points(T_base_link_submap, seen.origins)},
              {}};
    for (const SubmapScan& scan : submap.scans())
      view.way.push_back((T_base_link_submap * scan.T_submap_base_link).translation());
    return view;
  }

  /// Refines and scores, keeps the best of each place, best first.
  void judge(const View& view, const std::vector<Candidate>& found) {
    candidates.clear();
    for (const Candidate& candidate : found) consider(view, candidate);
  }

  void consider(const View& view, Candidate candidate) {
    const LocalizationMap& map = *maps[candidate.map];
    const Pose2 T_map_base_link = refined_coarse_to_fine(
        map.field(), view.evidence.ends, candidate.T_map_submap * T_submap_base_link);
    candidate.T_map_submap = T_map_base_link * inverse(T_submap_base_link);
    candidate.score = score_evidence(map.classes(), view.evidence, T_map_base_link);
    if (Candidate* same = find_same_place(candidate)) {
      candidate.votes = std::max(same->votes, candidate.votes);
      candidate.inliers = std::max(same->inliers, candidate.inliers);
      if (same->score.fit > candidate.score.fit) {
        same->votes = candidate.votes;
        same->inliers = candidate.inliers;
      } else {
        *same = candidate;
      }
    } else {
      candidates.push_back(candidate);
    }
    std::stable_sort(
        candidates.begin(), candidates.end(),
        [](const Candidate& a, const Candidate& b) { return a.score.fit > b.score.fit; });
    const double least =
        candidates.front().score.fit - kRivalMargin * candidates.front().score.ends;
    std::erase_if(candidates, [least](const Candidate& c) { return c.score.fit < least; });
    if (candidates.size() > kMaxCandidates) candidates.resize(kMaxCandidates);
  }

  Candidate* find_same_place(const Candidate& candidate) {
    const Pose2 T_map_base_link = candidate.T_map_submap * T_submap_base_link;
    for (Candidate& known : candidates) {
      const Pose2 other = known.T_map_submap * T_submap_base_link;
      if (known.map == candidate.map && is_same_place(other, T_map_base_link)) return &known;
    }
    return nullptr;
  }

  /// Log-likelihood of the best candidate less that of the best other place, at most what the last
  /// search would have found.
  [[nodiscard]] double gap() const { return gap_to_known(rival_margin); }

  /// The same if all places within `margin`, a beam end, are known.
  [[nodiscard]] double gap_to_known(double margin) const {
    const double best = candidates.front().score.log_likelihood;
    double gap = gap_without_rivals(margin);
    for (std::size_t i = 1; i < candidates.size(); ++i)
      gap = std::min(gap, best - candidates[i].score.log_likelihood);
    return gap;
  }

  /// When there is no other place within `margin`, a beam end.
  [[nodiscard]] double gap_without_rivals(double margin) const {
    const EvidenceScore& best = candidates.front().score;
    return std::min(best.log_likelihood - kMinPlaceWeight * best.ends, margin * best.ends);
  }

  [[nodiscard]] bool acceptable(double gap) const {
    const EvidenceScore& best = candidates.front().score;
    return gap >= params.acceptance.min_mean_gap * best.ends && gap >= params.acceptance.min_gap &&
           probability_right(best, gap) >= params.acceptance.min_probability;
  }

  void decide(const View& view) {
    const bool was_lost = status == Status::kLost;
    status = was_lost ? Status::kLost : Status::kCollecting;
    confidence = 0.0;
    if (candidates.empty()) {
      const bool few_features =
          params.method != Method::kIndexed &&
          submap.features().size() < static_cast<std::size_t>(params.min_features);
      reason = few_features ? Reason::kFewFeatures : Reason::kNoMatch;
      return;
    }
    confidence = probability_right(candidates.front().score, gap());
    if (acceptable(gap())) {
      if (mirror_image_fits_better(view)) {
        reason = Reason::kFewEvidence;
        return;
      }
      status = Status::kLocalized;
      reason = Reason::kNone;
      begin_tracking(candidates.front());
      misfits = 0;
      misfit_way_m = 0.0;
      return;
    }
    reason = missing_without_rivals();
    if (reason == Reason::kNone && !was_lost) status = Status::kAmbiguous;
  }

  /// What would be missing if there were no other place; kNone when only that stands in the way.
  [[nodiscard]] Reason missing_without_rivals() const {
    EvidenceScore best = candidates.front().score;
    const double gap = gap_without_rivals(kRivalMargin);
    if (gap <= 0.0) return Reason::kNoMatch;
    if (acceptable(gap)) return Reason::kNone;
    best.contradicted = 0.0;
    const bool only_contradicted =
        probability_right(best, gap) >= params.acceptance.min_probability;
    return only_contradicted ? Reason::kContradicted : Reason::kFewEvidence;
  }

  // --- tracking
  // ---------------------------------------------------------------------------------------------------

  void begin_tracking(const Candidate& candidate) {
    fix = candidate;
    tracker = PoseTracker(candidate.T_map_submap * T_submap_base_link);
  }

  /// Corrects the pose by the scan; takes it back when scans stay off the walls.
  void track(const RobotScan& robot_scan, const std::vector<Point2>& points, bool news) {
    const LocalizationMap& map = *maps[fix->map];
    const TrackingVerdict verdict =
        tracker.update(map, points, robot_scan.T_base_link_laser.translation());
    fix->T_map_submap = tracker.T_map_base_link() * inverse(T_submap_base_link);
    if (news) fix->score = score_evidence(map.classes(), submap.evidence(), fix->T_map_submap);
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
      answer.hypotheses.front().T_map_base_link = pose.T_map_base_link;
    } else {
      for (const Candidate& candidate : candidates) answer.hypotheses.push_back(ranked(candidate));
    }
    answer.local_scans = static_cast<int>(submap.size());
    answer.local_features = static_cast<int>(submap.features().size());
    answer.T_submap_base_link = T_submap_base_link;
    answer.times = times;
    return answer;
  }

  [[nodiscard]] RankedHypothesis ranked(const Candidate& candidate) const {
    return {maps[candidate.map],     candidate.T_map_submap * T_submap_base_link,
            candidate.votes,         candidate.inliers,
            candidate.score.matched, candidate.score};
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
    state.T_map_submap = impl_->fix->T_map_submap;
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
    Candidate fix{static_cast<std::size_t>(state.tracked_map), state.T_map_submap, 0, 0, {}};
    fix.score =
        score_evidence(impl_->maps[fix.map]->classes(), impl_->submap.evidence(), fix.T_map_submap);
    impl_->begin_tracking(fix);
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
