#include "bench/external/mrpt_localizer.hpp"

#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/random.h>
#include <mrpt/slam/CMonteCarloLocalization2D.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "bench/rivals/robot_motion.hpp"

namespace cornerfix::bench {
namespace {

// Of a scan, as many as its default takes of 180: more, which are no independent witnesses, make it
// too sure.
constexpr std::size_t kBeamsTaken = 36;
constexpr double kKnownPosition = 0.5;  // [m] of a known pose
// Widths of where it may be at a known start.
constexpr double kStartPosition = 0.5;  // [m]
constexpr double kStartYaw = std::numbers::pi / 12.0;

float free_probability(Cell cell) {
  switch (cell) {
    case Cell::kFree:
      return 0.95F;
    case Cell::kOccupied:
      return 0.05F;
    case Cell::kUnknown:
      break;
  }
  return 0.5F;
}

mrpt::poses::CPose2D to_mrpt(const Pose2& pose) { return {pose.x, pose.y, pose.yaw}; }

mrpt::obs::CObservation2DRangeScan::Ptr to_mrpt(const RobotScan& robot_scan) {
  const LaserScan& scan = robot_scan.scan;
  auto observation = mrpt::obs::CObservation2DRangeScan::Create();
  const double span = scan.angle_increment * static_cast<double>(scan.ranges.size() - 1);
  Pose2 T_base_link_middle = robot_scan.T_base_link_laser;
  T_base_link_middle.yaw = wrap_angle(T_base_link_middle.yaw + scan.angle_min + 0.5 * span);
  observation->aperture = static_cast<float>(std::abs(span));
  observation->rightToLeft = scan.angle_increment > 0.0;
  observation->maxRange = static_cast<float>(scan.range_max);
  observation->sensorPose = mrpt::poses::CPose3D(to_mrpt(T_base_link_middle));
  observation->resizeScan(scan.ranges.size());
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const bool valid = scan.has_return(beam);
    observation->setScanRange(beam, valid ? scan.ranges[beam] : 0.0F);
    observation->setScanRangeValidity(beam, valid);
  }
  return observation;
}

}  // namespace

struct MrptMap::Impl {
  mrpt::maps::COccupancyGridMap2D::Ptr grid = mrpt::maps::COccupancyGridMap2D::Create();
};

MrptMap::MrptMap(const OccupancyGrid& grid) : impl_(std::make_unique<Impl>()) {
  const auto resolution = static_cast<float>(grid.resolution);
  const auto x = static_cast<float>(grid.T_map_grid.x);
  const auto y = static_cast<float>(grid.T_map_grid.y);
  mrpt::maps::COccupancyGridMap2D& map = *impl_->grid;
  map.setSize(x, x + resolution * static_cast<float>(grid.width), y,
              y + resolution * static_cast<float>(grid.height), resolution, 0.5F);
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const Point2 center = grid.T_map_grid * grid.center({column, row});
      map.setCell(map.x2idx(static_cast<float>(center.x())),
                  map.y2idx(static_cast<float>(center.y())),
                  free_probability(grid.at({column, row})));
    }
  }
  map.likelihoodOptions.likelihoodMethod = mrpt::maps::COccupancyGridMap2D::lmLikelihoodField_Thrun;
}

MrptMap::~MrptMap() = default;

std::size_t MrptMap::bytes() const {
  const auto cells = static_cast<std::size_t>(impl_->grid->getSizeX()) * impl_->grid->getSizeY();
  return cells * (sizeof(mrpt::maps::COccupancyGridMap2D::cellType) + sizeof(double));
}

namespace {

class MrptLocalizer : public Rival {
 public:
  MrptLocalizer(std::shared_ptr<const MrptMap> map, const MrptParams& params,
                const std::optional<Pose2>& known)
      : map_(std::move(map)), filter_(params.update_distance_m, params.update_angle_rad) {
    mrpt::random::getRandomGenerator().randomize(params.seed);
    particle_filter_.m_options.PF_algorithm = mrpt::bayes::CParticleFilter::pfStandardProposal;
    particle_filter_.m_options.adaptiveSampleSize = true;
    particle_filter_.m_options.powFactor = params.power;
    poses_.options.metricMap = map_->impl().grid;
    auto& kld = poses_.options.KLD_params;
    kld.KLD_binSize_XY = 0.5;
    kld.KLD_binSize_PHI = std::numbers::pi / 18.0;
    kld.KLD_delta = 0.02;
    kld.KLD_epsilon = 0.02;
    kld.KLD_minSampleSize = 500;
    kld.KLD_maxSampleSize = static_cast<unsigned int>(params.max_particles);
    if (known) {
      poses_.resetAroundSetOfPoses({mrpt::math::TPose2D(known->x, known->y, known->yaw)},
                                   params.max_particles, kStartPosition, kStartPosition, kStartYaw);
      converged_ = true;
    } else {
      poses_.resetUniformFreeSpace(map_->impl().grid.get(), 0.7,
                                   static_cast<int>(params.max_particles));
    }
  }

  RivalAnswer process(const RobotScan& scan) override {
    if (!scan.T_odom_base_link) return {std::nullopt, false};  // it has no other motion model
    const Pose2 now = *scan.T_odom_base_link;
    if (!filter_.opens(now)) {
      if (!converged_) return {std::nullopt, false};
      return {mean_ * motion_between(last_T_odom_base_link_, now), false};
    }
    update(motion_between(last_T_odom_base_link_, now), scan);
    last_T_odom_base_link_ = now;
    converged_ = summarize() || converged_;
    if (!converged_) return {};
    return {mean_, true};
  }

  [[nodiscard]] std::size_t bytes() const override {
    return poses_.m_particles.size() * sizeof(poses_.m_particles[0]);
  }

 private:
  void update(const Pose2& motion, const RobotScan& scan) {
    map_->impl().grid->likelihoodOptions.LF_decimation =
        static_cast<std::uint32_t>(std::max<std::size_t>(1, scan.scan.ranges.size() / kBeamsTaken));
    mrpt::obs::CActionRobotMovement2D movement;
    mrpt::obs::CActionRobotMovement2D::TMotionModelOptions model;
    model.modelSelection = mrpt::obs::CActionRobotMovement2D::mmGaussian;
    // Its defaults of 0.01 m and 0.2 deg leave no way from one particle's place to the next one's.
    model.gaussianModel.minStdXY = 0.10;
    model.gaussianModel.minStdPHI = std::numbers::pi / 60.0;
    movement.computeFromOdometry(to_mrpt(motion), model);
    mrpt::obs::CActionCollection actions;
    actions.insert(movement);
    mrpt::obs::CSensoryFrame frame;
    frame.insert(to_mrpt(scan));
    particle_filter_.executeOn(poses_, &actions, &frame);
  }

  /// Mean of the particles; whether they lie together.
  bool summarize() {
    double weights = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, c = 0.0, s = 0.0;
    for (const auto& particle : poses_.m_particles) {
      const double weight = std::exp(particle.log_w);
      weights += weight;
      x += weight * particle.d.x;
      y += weight * particle.d.y;
      xx += weight * particle.d.x * particle.d.x;
      yy += weight * particle.d.y * particle.d.y;
      c += weight * std::cos(particle.d.phi);
      s += weight * std::sin(particle.d.phi);
    }
    mean_ = {x / weights, y / weights, std::atan2(s, c)};
    const double variance_x = xx / weights - mean_.x * mean_.x;
    const double variance_y = yy / weights - mean_.y * mean_.y;
    constexpr double kVariance = kKnownPosition * kKnownPosition;
    return variance_x <= kVariance && variance_y <= kVariance;
  }

  std::shared_ptr<const MrptMap> map_;
  MotionFilter filter_;
  mrpt::bayes::CParticleFilter particle_filter_;
  mrpt::slam::CMonteCarloLocalization2D poses_;
  std::optional<Pose2> last_T_odom_base_link_;
  Pose2 mean_;
  bool converged_ = false;
};

}  // namespace

std::unique_ptr<Rival> make_mrpt_localizer(std::shared_ptr<const MrptMap> map,
                                           const MrptParams& params,
                                           const std::optional<Pose2>& T_map_base_link) {
  return std::make_unique<MrptLocalizer>(std::move(map), params, T_map_base_link);
}

}  // namespace cornerfix::bench
