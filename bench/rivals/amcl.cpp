#include "bench/rivals/amcl.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "bench/rivals/particle_bins.hpp"

namespace cornerfix::bench {
namespace {

constexpr double kKnownPosition = 0.5;                 // [m] of a known start
constexpr double kKnownYaw = std::numbers::pi / 12.0;  // [rad]
constexpr double kConvergedWeight = 0.95;
constexpr double kConvergedPosition = 0.5;  // [m]

/// Particles so that the distribution over `bins` is within kld_err of the true one (Fox 2001).
std::size_t kld_limit(std::size_t bins, const AmclParams& params) {
  if (bins <= 1) return params.max_particles;
  const double k = static_cast<double>(bins) - 1.0;
  const double b = 2.0 / (9.0 * k);
  const double x = 1.0 - b + std::sqrt(b) * params.kld_z;
  const double count = std::ceil(k / (2.0 * params.kld_err) * x * x * x);
  return std::clamp(static_cast<std::size_t>(count), params.min_particles, params.max_particles);
}

/// A move of half a turn less is the same move backwards.
double turn_noise(double turn) {
  return std::min(std::abs(wrap_angle(turn)), std::abs(wrap_angle(turn - std::numbers::pi)));
}

double squared(double value) { return value * value; }

}  // namespace

Amcl::Amcl(const OccupancyGrid& grid, const DistanceField& field, const AmclParams& params)
    : grid_(grid), field_(field), params_(params), random_(params.seed) {
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    if (grid.cells[i] == Cell::kFree) free_cells_.push_back(i);
  }
  assert(!free_cells_.empty() && "no place for a robot");
  particles_.resize(params.max_particles);
  for (Particle& particle : particles_)
    particle = {uniform_pose(), 1.0 / static_cast<double>(params.max_particles)};
}

void Amcl::set_pose(const Pose2& T_map_base_link) {
  std::normal_distribution<double> normal;
  particles_.resize(params_.max_particles);
  for (Particle& particle : particles_) {
    particle.T_map_base_link = {T_map_base_link.x + kKnownPosition * normal(random_),
                                T_map_base_link.y + kKnownPosition * normal(random_),
                                wrap_angle(T_map_base_link.yaw + kKnownYaw * normal(random_))};
    particle.weight = 1.0 / static_cast<double>(particles_.size());
  }
  converged_ = true;
  last_T_odom_base_link_.reset();
}

Pose2 Amcl::uniform_pose() {
  const std::size_t cell = free_cells_[random_() % free_cells_.size()];
  const auto width = static_cast<std::size_t>(grid_.width);
  const Point2 point = grid_.T_map_grid * grid_.center({static_cast<int>(cell % width),
                                                        static_cast<int>(cell / width)});
  std::uniform_real_distribution<double> heading(-std::numbers::pi, std::numbers::pi);
  return {point.x(), point.y(), heading(random_)};
}

RivalAnswer Amcl::process(const RobotScan& scan) {
  if (!scan.T_odom_base_link) return {std::nullopt, false};  // it has no other motion model
  const Pose2 now = *scan.T_odom_base_link;
  if (last_T_odom_base_link_) {
    const Pose2& before = *last_T_odom_base_link_;
    const bool moved = std::abs(now.x - before.x) > params_.update_min_d ||
                       std::abs(now.y - before.y) > params_.update_min_d ||
                       angle_between(now, before) > params_.update_min_a;
    if (!moved && !converged_) return {std::nullopt, false};
    if (!moved)
      return {heaviest_.mean * (inverse(before) * now), false};  // as its map -> odom transform
    move(before, now);
  }
  last_T_odom_base_link_ = now;
  weigh(scan);
  if (++updates_ % params_.resample_interval == 0) resample();
  find_heaviest_cluster();
  converged_ = converged_ || (heaviest_.weight >= kConvergedWeight &&
                              heaviest_.deviation.x <= kConvergedPosition &&
                              heaviest_.deviation.y <= kConvergedPosition);
  if (!converged_) return {};
  return {heaviest_.mean, true};
}

/// Thrun et al. 2005, table 5.6: the motion model of odometry.
void Amcl::move(const Pose2& before, const Pose2& now) {
  const double x = now.x - before.x;
  const double y = now.y - before.y;
  const double translation = std::hypot(x, y);
  const double rotation1 = translation < 0.01 ? 0.0 : wrap_angle(std::atan2(y, x) - before.yaw);
  const double rotation2 = wrap_angle(now.yaw - before.yaw - rotation1);
  const double noise1 = squared(turn_noise(rotation1));
  const double noise2 = squared(turn_noise(rotation2));
  const double sigma1 =
      std::sqrt(params_.odom_alpha1 * noise1 + params_.odom_alpha2 * squared(translation));
  const double sigma_translation = std::sqrt(params_.odom_alpha3 * squared(translation) +
                                             params_.odom_alpha4 * (noise1 + noise2));
  const double sigma2 =
      std::sqrt(params_.odom_alpha1 * noise2 + params_.odom_alpha2 * squared(translation));
  std::normal_distribution<double> normal;
  for (Particle& particle : particles_) {
    Pose2& pose = particle.T_map_base_link;
    const double first = rotation1 - sigma1 * normal(random_);
    const double length = translation - sigma_translation * normal(random_);
    const double second = rotation2 - sigma2 * normal(random_);
    pose.x += length * std::cos(pose.yaw + first);
    pose.y += length * std::sin(pose.yaw + first);
    pose.yaw = wrap_angle(pose.yaw + first + second);
  }
}

/// Thrun et al. 2005, table 6.3, the likelihood field, with the cubed sum of ROS's AMCL for the
/// product. Then the averages of table 8.3 that show when it is lost.
void Amcl::weigh(const RobotScan& scan) {
  const auto beams = static_cast<int>(scan.scan.ranges.size());
  const int step = std::max(1, (beams - 1) / std::max(1, params_.laser_max_beams - 1));
  std::vector<Point2> ends;
  for (int beam = 0; beam < beams; beam += step) {
    const auto index = static_cast<std::size_t>(beam);
    if (!scan.scan.has_return(index)) continue;
    const auto range = static_cast<double>(scan.scan.ranges[index]);
    const double bearing = scan.scan.bearing(index);
    ends.push_back(scan.T_base_link_laser *
                   Point2(range * std::cos(bearing), range * std::sin(bearing)));
  }
  const double rand = params_.laser_z_rand / scan.scan.range_max;
  const double hit_exponent = -0.5 / squared(params_.laser_sigma_hit);
  const Pose2 T_grid_map = field_.T_grid_frame();
  double total = 0.0;
  for (Particle& particle : particles_) {
    const Pose2 T_grid_base_link = T_grid_map * particle.T_map_base_link;
    const double c = std::cos(T_grid_base_link.yaw);
    const double s = std::sin(T_grid_base_link.yaw);
    double p = 1.0;
    for (const Point2& end : ends) {
      const double z = std::min(params_.laser_likelihood_max_dist,
                                field_.nearest({T_grid_base_link.x + c * end.x() - s * end.y(),
                                                T_grid_base_link.y + s * end.x() + c * end.y()}));
      const double pz = params_.laser_z_hit * std::exp(hit_exponent * z * z) + rand;
      p += pz * pz * pz;
    }
    particle.weight *= p;
    total += particle.weight;
  }
  const double average = total / static_cast<double>(particles_.size());
  for (Particle& particle : particles_) particle.weight /= total;
  const auto approach = [average](double& value, double alpha) {
    value = value == 0.0 ? average : value + alpha * (average - value);
  };
  approach(w_slow_, params_.recovery_alpha_slow);
  approach(w_fast_, params_.recovery_alpha_fast);
}

/// Fox 2001: draws until there are enough for the bins that they fill; some anywhere when lost.
void Amcl::resample() {
  std::vector<double> sums{0.0};
  for (const Particle& particle : particles_) sums.push_back(sums.back() + particle.weight);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const auto draw = [&] {
    const double at = share(random_) * sums.back();
    const auto above =
        params_.linear_resampling
            ? std::find_if(sums.begin() + 1, sums.end(), [at](double sum) { return at < sum; })
            : std::upper_bound(sums.begin() + 1, sums.end(), at);
    const auto index = static_cast<std::size_t>(above - sums.begin() - 1);
    return particles_[std::min(index, particles_.size() - 1)].T_map_base_link;
  };
  const double lost = std::max(0.0, 1.0 - w_fast_ / w_slow_);
  ParticleBins bins;
  std::vector<Particle> drawn;
  while (drawn.size() < params_.max_particles) {
    drawn.push_back({share(random_) < lost ? uniform_pose() : draw(), 0.0});
    bins.insert(drawn.back().T_map_base_link);
    if (drawn.size() > kld_limit(bins.size(), params_)) break;
  }
  if (lost > 0.0) w_slow_ = w_fast_ = 0.0;
  for (Particle& particle : drawn) particle.weight = 1.0 / static_cast<double>(drawn.size());
  particles_ = std::move(drawn);
}

void Amcl::find_heaviest_cluster() {
  ParticleBins bins;
  for (const Particle& particle : particles_) bins.insert(particle.T_map_base_link);
  struct Sums {
    double weight = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, c = 0.0, s = 0.0;
  };
  std::vector<Sums> clusters(bins.find_clusters());
  for (const Particle& particle : particles_) {
    Sums& sums = clusters[bins.cluster_of(particle.T_map_base_link)];
    const Pose2& pose = particle.T_map_base_link;
    sums.weight += particle.weight;
    sums.x += particle.weight * pose.x;
    sums.y += particle.weight * pose.y;
    sums.xx += particle.weight * squared(pose.x);
    sums.yy += particle.weight * squared(pose.y);
    sums.c += particle.weight * std::cos(pose.yaw);
    sums.s += particle.weight * std::sin(pose.yaw);
  }
  const Sums& best = *std::ranges::max_element(clusters, {}, &Sums::weight);
  const double x = best.x / best.weight;
  const double y = best.y / best.weight;
  const double resultant = std::min(1.0, std::hypot(best.c, best.s) / best.weight);
  heaviest_.weight = best.weight;
  heaviest_.mean = {x, y, std::atan2(best.s, best.c)};
  heaviest_.deviation = {std::sqrt(std::max(0.0, best.xx / best.weight - squared(x))),
                         std::sqrt(std::max(0.0, best.yy / best.weight - squared(y))),
                         std::sqrt(std::max(0.0, -2.0 * std::log(std::max(resultant, 1e-300))))};
}

std::size_t Amcl::bytes() const {
  return particles_.capacity() * sizeof(Particle) + free_cells_.size() * sizeof(std::size_t);
}

}  // namespace cornerfix::bench
