#include "evaluation/metrics/slam_run.hpp"

#include <utility>

#include <cornerfix/slam.hpp>

namespace cornerfix::evaluation {

namespace {

/// Where a scan lies: relative to its keyframe.
struct Stop {
  std::size_t keyframe = 0;
  Pose2 T_keyframe_laser;
};

}  // namespace

Result<SlamRun> run_slam(std::span<const LogScan> scans, bool use_odometry,
                         const MapperParams& params, const std::function<void(double)>& progress) {
  constexpr double kOdometryShare = 0.4;  // of the work
  SlamRun run;
  LidarOdometry lidar_odometry;
  Mapper mapper(params);
  std::vector<Stop> stops;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto odometry = use_odometry ? scans[i].T_odom_laser : std::nullopt;
    PosedScan posed{scans[i].scan, {}, lidar_odometry.process({scans[i].scan, {}, odometry})};
    const Pose2 T_map_laser = posed.T_map_base_link;
    if (mapper.is_key_frame(posed)) {
      mapper.add(std::move(posed));
      run.key_scans.push_back(i);
    }
    stops.push_back({run.key_scans.size() - 1,
                     inverse(mapper.key_frames().back().T_map_base_link) * T_map_laser});
    if (progress)
      progress(kOdometryShare * static_cast<double>(i) / static_cast<double>(scans.size()));
  }
  const auto optimized = optimize_trajectory(mapper.key_frames(), [&](double share) {
    if (progress) progress(kOdometryShare + (1.0 - kOdometryShare) * share);
    return true;
  });
  if (!optimized) return optimized.error();
  for (const Stop& stop : stops)
    run.T_map_laser.push_back(optimized->T_map_base_link[stop.keyframe] * stop.T_keyframe_laser);
  run.submaps = optimized->submaps;
  run.loop_closures = optimized->loop_closures;
  return run;
}

}  // namespace cornerfix::evaluation
