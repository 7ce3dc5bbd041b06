/// \file  ROS AMCL: adaptive Monte Carlo localization with the likelihood-field model.
///
/// Fox 2001 (KLD sampling) and Thrun, Burgard, Fox 2005 (tables 5.6, 6.3 and 8.3), with the
/// algorithm, the parameter names and the defaults of ROS's `amcl`. Other defaults are marked. Its
/// own sampler walks the whole set for each particle that it draws; `linear_resampling` false looks
/// it up instead.
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <cornerfix/occupancy_grid.hpp>

#include "bench/rivals/rival.hpp"
#include "bench/rivals/robot_motion.hpp"
#include "core/src/map/distance_field.hpp"

namespace cornerfix::bench {

struct AmclParams {
  std::size_t min_particles = 100;
  std::size_t max_particles = 20'000;  ///< ROS: 5,000; the paper: 20,000.
  double kld_err = 0.01;
  double kld_z = 0.99;
  double update_min_d = 0.2;     ///< [m]
  double update_min_a = 0.5236;  ///< [rad]
  int resample_interval = 2;
  double recovery_alpha_slow = 0.001;  ///< ROS: off; its documentation advises this value.
  double recovery_alpha_fast = 0.1;    ///< ROS: off; its documentation advises this value.
  double odom_alpha1 = 0.05;  ///< These four in ROS: 0.2, which spreads the headings by 20 deg.
  double odom_alpha2 = 0.05;
  double odom_alpha3 = 0.05;
  double odom_alpha4 = 0.05;
  int laser_max_beams = 60;  ///< ROS: 30; more constrain more.
  double laser_z_hit = 0.95;
  double laser_z_rand = 0.05;
  double laser_sigma_hit = 0.2;            ///< [m]
  double laser_likelihood_max_dist = 2.0;  ///< [m]
  bool linear_resampling = true;
  std::uint64_t seed = 1;
};

/// A group of particles that lie side by side.
struct ParticleCluster {
  double weight = 0.0;
  Pose2 mean;
  Pose2 deviation;  ///< Standard deviations of x, y [m] and yaw [rad].
};

/// One robot in one map. The pose is the mean of the heaviest cluster. It is given once that
/// cluster has 0.95 of the weight and is no wider than 0.5 m, and from then on always. (ROS's AMCL
/// gives it from the first scan on; its test of convergence uses positions only, too.)
class Amcl : public Rival {
 public:
  /// `grid` and `field` must outlive it. Starts with particles all over the free space.
  Amcl(const OccupancyGrid& grid, const DistanceField& field, const AmclParams& params);

  /// Begins anew about a known pose, as unsure of it as ROS takes a known start to be (0.5 m, 15
  /// deg).
  void set_pose(const Pose2& T_map_base_link);

  [[nodiscard]] RivalAnswer process(const RobotScan& scan) override;
  [[nodiscard]] std::size_t bytes() const override;

  [[nodiscard]] std::size_t particle_count() const { return particles_.size(); }
  [[nodiscard]] const ParticleCluster& heaviest_cluster() const { return heaviest_; }

 private:
  struct Particle {
    Pose2 T_map_base_link;
    double weight = 0.0;
  };

  [[nodiscard]] Pose2 uniform_pose();
  void move(const Pose2& before, const Pose2& now);
  void weigh(const RobotScan& scan);
  void resample();
  void find_heaviest_cluster();

  const OccupancyGrid& grid_;
  const DistanceField& field_;
  AmclParams params_;
  std::mt19937_64 random_;
  std::vector<std::size_t> free_cells_;
  std::vector<Particle> particles_;
  double w_slow_ = 0.0;
  double w_fast_ = 0.0;
  int updates_ = 0;
  std::optional<Pose2> last_T_odom_base_link_;
  ParticleCluster heaviest_;
  bool converged_ = false;
};

}  // namespace cornerfix::bench
