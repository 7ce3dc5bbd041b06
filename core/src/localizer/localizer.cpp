#include "core/src/localizer/localizer_impl.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/src/scan/finite_scan.hpp"

namespace cornerfix {
namespace {

constexpr int kMaxStillScans = 10;  // without anything new: say that driving on would help

}  // namespace

Answer Localizer::Impl::process(const RobotScan& robot_scan) {
  assert(!last_stamp || robot_scan.scan.stamp >= *last_stamp);
  StepTimes times;
  const double begin = now();
  searched = false;
  is_doubted = false;
  withdrawal = Withdrawal::kNone;
  const std::vector<Point2> points = points_to_match(robot_scan.scan, robot_scan.T_base_link_laser);
  move_along(robot_scan, points);
  times.odometry_ms = now() - begin;

  const double extract_begin = now();
  const bool news =
      !points.empty() && submap.wants(T_submap_base_link, robot_scan.T_base_link_laser);
  if (news) keep(robot_scan);
  still_scans = news ? 0 : still_scans + 1;
  times.extract_ms = now() - extract_begin;

  if (accepted) {
    const double track_begin = now();
    track(robot_scan, points, news);
    times.track_ms = now() - track_begin;
  } else if (news || search.is_suspended()) {
    look_for_robot(times);
    if (accepted) track(robot_scan, points, false);
  } else if (submap.empty()) {
    reason = Reason::kNoReturns;
  } else if (still_scans >= kMaxStillScans && status == Status::kCollecting) {
    reason = Reason::kNoMotion;
  }
  ++scans;
  times.total_ms = now() - begin;
  return answer(times);
}

void Localizer::Impl::keep(const RobotScan& robot_scan) {
  SubmapScan kept{0, robot_scan.scan, robot_scan.T_base_link_laser, T_submap_base_link};
  submap.keep(std::move(kept), corners_of(robot_scan.scan));
}

std::vector<Feature> Localizer::Impl::corners_of(const LaserScan& scan) const {
  return extract_corners(scan, params.extractor);
}

Answer Localizer::Impl::answer(const StepTimes& times) const {
  Answer answer;
  answer.status = is_doubted && accepted ? Status::kLost : status;
  answer.odometry = last_T_odom_base_link ? odometry_monitor.use() : OdometryUse::kNone;
  answer.withdrawal = withdrawal;
  answer.terms = terms;
  answer.is_given_region = region.has_value();
  answer.searched = searched;
  answer.searched_maps = source ? source->size() : maps.size();
  answer.reason = answer.status == Status::kLocalized ? Reason::kNone : reason;
  if (is_doubted && accepted) answer.reason = Reason::kContradicted;
  if (answer.reason == Reason::kContradicted && answer.odometry == OdometryUse::kIgnored)
    answer.reason = Reason::kOdometryContradictsScans;
  if (answer.status == Status::kLocalized || !accepted) answer.confidence = confidence;
  if (accepted && is_doubted) {
    answer.hypotheses.push_back(ranked(*accepted));
  } else if (accepted) {
    LocalizedPose pose{maps[accepted->map], tracker.T_map_base_link(), {}, epoch, confirmed};
    const Eigen::Matrix3d covariance = tracker.covariance();
    std::copy_n(covariance.data(), 9, pose.covariance.begin());  // symmetric: any order will do
    answer.pose = pose;
    answer.hypotheses.push_back(ranked(*accepted));
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

RankedHypothesis Localizer::Impl::ranked(const Candidate& candidate) const {
  return {maps[candidate.map], candidate.T_map_base_link, candidate.votes,
          candidate.inliers,   candidate.score.matched,   candidate.score};
}

Localizer::Localizer(std::vector<LocalizationMapPtr> maps, LocalizerParams params, Clock clock)
    : impl_(std::make_unique<Impl>(std::move(maps), params, std::move(clock))) {}
Localizer::Localizer(std::shared_ptr<MapSource> source, std::span<const MapKey> held,
                     LocalizerParams params, Clock clock)
    : Localizer(std::vector<LocalizationMapPtr>(), params, std::move(clock)) {
  for (const MapKey key : held) {
    LocalizationMapPtr map = source->load(key, 0);
    if (!map) continue;
    impl_->selection.keys.push_back(key);
    impl_->selection.maps.push_back(std::move(map));
  }
  impl_->maps = impl_->selection.maps;
  impl_->source = std::move(source);
}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

Answer Localizer::process(const RobotScan& scan) {
  const bool is_finite = has_finite_geometry(scan.scan, scan.T_base_link_laser);
  return impl_->process(is_finite ? scan : without_returns(scan));
}

void Localizer::reset(std::optional<StartRegion> region) {
  assert(!region || !validate(*region));
  const std::uint64_t epoch = impl_->epoch;
  const OdometryMonitor odometry_monitor = impl_->odometry_monitor;
  std::shared_ptr<MapSource> source = std::move(impl_->source);
  MapSelection selection = std::move(impl_->selection);
  *impl_ = Impl(std::move(impl_->maps), impl_->params, std::move(impl_->clock));
  impl_->source = std::move(source);
  impl_->selection = std::move(selection);
  impl_->epoch = epoch;
  impl_->odometry_monitor = odometry_monitor;
  impl_->restrict_to(std::move(region));
}

const std::optional<StartRegion>& Localizer::region() const { return impl_->region; }

void Localizer::replace_maps(std::vector<LocalizationMapPtr> maps) {
  assert(maps.size() >= impl_->maps.size() && "maps may join at the end, none may leave");
  assert((!impl_->source || maps.size() == impl_->maps.size()) && "a source has the other maps");
  impl_->maps = std::move(maps);
  if (impl_->source) impl_->selection.maps = impl_->maps;
}

std::optional<double> Localizer::last_stamp() const { return impl_->last_stamp; }

const std::vector<MapKey>& Localizer::map_keys() const { return impl_->selection.keys; }

const std::vector<LocalizationMapPtr>& Localizer::maps() const { return impl_->maps; }

std::vector<Point2> Localizer::local_features_base_link() const {
  const Pose2 T_base_link_submap = inverse(impl_->T_submap_base_link);
  std::vector<Point2> points;
  for (const Feature& feature : impl_->submap.features())
    points.push_back(T_base_link_submap * feature.position);
  return points;
}

}  // namespace cornerfix
