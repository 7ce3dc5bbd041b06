#include "core/src/localizer/localizer_impl.hpp"

#include <algorithm>
#include <utility>

#include "core/src/search/map_index.hpp"

namespace cornerfix {

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
  if (impl_->accepted) {
    state.tracked_map = static_cast<int>(impl_->accepted->map);
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
  for (const SubmapScanPtr& scan : state.submap) {
    if (!old_ground && scan->index >= state.accepted_index) old_ground = impl_->submap.evidence();
    std::vector<Feature> corners = impl_->corners_of(scan->scan);
    impl_->submap.keep(*scan, std::move(corners), true);
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
    Candidate accepted{static_cast<std::size_t>(state.tracked_map),
                       state.T_map_submap * state.T_submap_base_link,
                       0,
                       0,
                       {}};
    accepted.score = score_evidence(impl_->maps[accepted.map]->index().classes,
                                    impl_->submap.evidence(), state.T_map_submap);
    impl_->begin_tracking(accepted);
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

}  // namespace cornerfix
