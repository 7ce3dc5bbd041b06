/// \file  What a Localizer holds, and its steps: motion (localizer_motion.cpp), search and decision
/// (localizer_decision.cpp), tracking and review (localizer_tracking.cpp), and what a restart keeps
/// (localizer_state.cpp).
#pragma once

#include <cornerfix/localizer.hpp>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/src/acceptance/new_ground.hpp"
#include "core/src/local_map/scan_motion.hpp"
#include "core/src/search/global_search.hpp"
#include "core/src/search/map_selection.hpp"
#include "core/src/tracking/odometry_monitor.hpp"
#include "core/src/tracking/pose_tracker.hpp"

namespace cornerfix {

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
  std::shared_ptr<MapSource> source;  ///< Of maps; null when `maps` are all.
  MapSelection selection;             ///< `maps` with their keys, with a source.
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
  std::optional<StartRegion> region;         ///< While it restricts the search.
  bool searched = false;                     ///< At this scan.
  std::optional<std::uint64_t> selected_at;  ///< `scans` at the last selection.
  OdometryMonitor odometry_monitor;

  Status status = Status::kCollecting;
  Reason reason = Reason::kFewFeatures;
  double confidence = 0.0;
  AcceptanceTerms terms;  ///< Of the last decision.

  std::optional<Candidate> accepted;  ///< While localized.
  PoseTracker tracker;                ///< Of the accepted pose.
  Pose2 T_map_submap;                 ///< By the accepted pose.
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
  Answer process(const RobotScan& robot_scan);
  void keep(const RobotScan& robot_scan);
  [[nodiscard]] std::vector<Feature> corners_of(const LaserScan& scan) const;

  // --- motion

  /// Scan-to-submap matching. Odometry predicts the motion as far as it agrees with the scans, the
  /// motion before where it does not.
  void move_along(const RobotScan& robot_scan, const std::vector<Point2>& points);
  struct PredictedPose {
    PosePrior prior;
    /// Covariance that the motion adds where the scan does not constrain it, of x, y, yaw along the
    /// axes of the submap.
    Eigen::Matrix3d drift;
  };
  /// What is known of the pose at a scan before it is matched.
  struct Prediction {
    PredictedPose likely;
    /// The other one of odometry and constant velocity; none while odometry is ignored or stands.
    std::optional<PredictedPose> alternative;
    bool is_odometry_likely = false;
    std::optional<Pose2> odometry;  ///< Motion since the last scan.
  };
  [[nodiscard]] Prediction predict(const RobotScan& robot_scan);
  [[nodiscard]] PredictedPose predict_by_odometry(const Pose2& motion) const;
  /// The motion until the next scan, `interval_s` after the last.
  [[nodiscard]] Pose2 motion_at_constant_velocity(double interval_s) const;
  struct Match {
    RefinedPose pose;
    PredictedPose from;  ///< What it started from.
  };
  /// Lays a scan on the submap from the likely prediction, and from the alternative where that
  /// leads to no match or odometry is implausible.
  [[nodiscard]] Match match(const std::vector<Point2>& points, const Prediction& prediction) const;
  [[nodiscard]] double least_matched_share() const;
  /// The velocity is that since the last scan of the same laser, because scans of two lasers may
  /// be too near in time. `last_moment` is that of the last scan of any.
  void note_velocity(LaserMoment last_moment);
  bool belongs_to_submap(double matched_share, bool is_new_laser);
  /// The scans no longer continue the submap: all that was derived from it is void.
  void restart_submap(Withdrawal cause);

  // --- search and decision

  void restrict_to(std::optional<StartRegion> start_region);
  void look_for_robot(StepTimes& times);
  /// Loads the maps where the robot may be, by what it saw.
  void select_from_source(const View& view);
  /// Keeps the map of the accepted pose only, with a source.
  void release_other_maps();
  void decide(const View& view);
  [[nodiscard]] Reason no_match() const;
  /// What stands in the way when maps that may hold the robot were not searched; kNone when all
  /// were.
  [[nodiscard]] Reason unsearched() const;
  void accept(const Candidate& best);

  // --- tracking and review

  void begin_tracking(const Candidate& candidate);
  /// Corrects the pose by the scan and withdraws it when scans contradict the map.
  void track(const RobotScan& robot_scan, const std::vector<Point2>& points, bool news);
  /// Judges new ground, then repeats the decision with what was seen since the acceptance.
  void review_acceptance(bool is_search_due);
  /// Repeats the decision. Returns whether the pose is still the best one.
  bool review_again(bool is_search_due);
  /// A scan that does not confirm the pose; too many in a row take it back.
  void miss(Reason why);
  /// The pose is no longer an answer; the submap and the search go on.
  void withdraw(Withdrawal cause);

  // --- answer

  [[nodiscard]] Answer answer(const StepTimes& times) const;
  [[nodiscard]] RankedHypothesis ranked(const Candidate& candidate) const;
};

}  // namespace cornerfix
