#include "core/src/local_map/submap.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/src/base/thinned.hpp"
#include "core/src/map/field_stamp.hpp"

namespace cornerfix {
namespace {

constexpr double kCoarseKernel = 0.4;
constexpr double kFineKernel = 0.12;
constexpr double kNormalError = 0.3;  // of walls drawn from a few scans [rad]

Pose2 field_corner(const SubmapParams& params, const Point2& center) {
  const double half = 0.5 * params.field_extent_m;
  return {center.x() - half, center.y() - half, 0.0};
}

TiledField empty_field(const SubmapParams& params, const Point2& center) {
  const int cells = static_cast<int>(std::ceil(params.field_extent_m / params.field_resolution_m));
  return {field_corner(params, center), params.field_resolution_m, cells, cells};
}

}  // namespace

Submap::Submap(SubmapParams params)
    : params_(params),
      field_(empty_field(params, Point2::Zero())),
      evidence_grid_(std::in_place, Point2::Zero(), params.evidence),
      features_(params.features) {}

bool is_same_laser(const Pose2& T_base_link_laser, const Pose2& T_base_link_other) {
  constexpr double kDistance = 0.05;  // [m]
  constexpr double kAngle = 0.05;     // [rad]
  return distance(T_base_link_laser, T_base_link_other) < kDistance &&
         angle_between(T_base_link_laser, T_base_link_other) < kAngle;
}

bool Submap::wants(const Pose2& T_submap_base_link, const Pose2& T_base_link_laser) const {
  const SubmapScan* last = last_scan_of(T_base_link_laser);
  return last == nullptr ||
         distance(last->T_submap_base_link, T_submap_base_link) >= params_.keep_distance_m ||
         angle_between(last->T_submap_base_link, T_submap_base_link) >= params_.keep_angle_rad;
}

bool Submap::knows_laser(const Pose2& T_base_link_laser) const {
  return last_scan_of(T_base_link_laser) != nullptr;
}

const SubmapScan* Submap::last_scan_of(const Pose2& T_base_link_laser) const {
  const auto found = std::find_if(kept_.rbegin(), kept_.rend(), [&](const Kept& kept) {
    return is_same_laser(kept.scan->T_base_link_laser, T_base_link_laser);
  });
  return found == kept_.rend() ? nullptr : found->scan.get();
}

void Submap::keep(SubmapScan scan, std::vector<Feature> corners_laser, bool restored) {
  if (!restored) scan.index = next_index_++;
  const Pose2 T_submap_laser = scan.T_submap_base_link * scan.T_base_link_laser;
  for (Feature& corner : corners_laser) corner = transformed(T_submap_laser, corner);
  Kept kept{std::make_shared<const SubmapScan>(std::move(scan)), std::move(corners_laser), 0.0};
  if (!kept_.empty()) {
    kept.way_m = kept_.back().way_m +
                 distance(kept_.back().scan->T_submap_base_link, kept.scan->T_submap_base_link);
  }
  std::vector<Point2> walls_grid;
  append_walls_of(*kept.scan, walls_grid);
  field_.stamp(walls_grid, params_.stamp_radius_m);
  if (evidence_grid_) evidence_grid_->add(kept.scan->scan, T_submap_laser);
  features_.insert(kept.corners_submap);
  const double way = kept.way_m;
  const Point2 position = kept.scan->T_submap_base_link.translation();
  kept_.push_back(std::move(kept));

  bool forgot = false;
  while (way - kept_.front().way_m > params_.window_m || kept_.size() > params_.max_scans) {
    const SubmapScan& old = *kept_.front().scan;
    if (evidence_grid_)
      evidence_grid_->remove(old.scan, old.T_submap_base_link * old.T_base_link_laser);
    kept_.pop_front();
    forgot = true;
  }
  if (forgot) {
    features_ = FeatureMap(params_.features);
    for (const Kept& one : kept_) features_.insert(one.corners_submap);
  }
  // The fields are squares; move them along before the robot's surroundings reach their border.
  // That also wipes forgotten walls from the field that scans are matched on.
  if ((position - center_).cwiseAbs().maxCoeff() > 0.2 * params_.field_extent_m)
    rebuild_about(position);
  evidence_.reset();
}

const Evidence& Submap::evidence() const {
  if (!evidence_)
    evidence_ = evidence_grid_ ? evidence_grid_->collect() : evidence_of_kept().collect();
  return *evidence_;
}

void Submap::stop_gathering_evidence() {
  evidence_grid_.reset();
  evidence_.reset();
}

void Submap::gather_evidence() {
  if (!evidence_grid_) evidence_grid_ = evidence_of_kept();
}

EvidenceGrid Submap::evidence_of_kept() const {
  EvidenceGrid grid(center_, params_.evidence);
  for (const Kept& kept : kept_)
    grid.add(kept.scan->scan, kept.scan->T_submap_base_link * kept.scan->T_base_link_laser);
  return grid;
}

void Submap::append_walls_of(const SubmapScan& scan, std::vector<Point2>& walls_grid) const {
  const Pose2 T_submap_laser = scan.T_submap_base_link * scan.T_base_link_laser;
  append_walls(walls_grid, scan.scan, field_.T_grid_frame() * T_submap_laser, field_.resolution(),
               std::numeric_limits<double>::infinity());
}

void Submap::rebuild_about(const Point2& center) {
  center_ = center;
  field_.clear(field_corner(params_, center));
  const double way = kept_.back().way_m;
  std::vector<Point2> walls_grid;
  for (const Kept& kept : kept_) {
    if (way - kept.way_m <= params_.match_window_m) append_walls_of(*kept.scan, walls_grid);
  }
  field_.stamp(walls_grid, params_.stamp_radius_m);
  if (evidence_grid_) evidence_grid_ = evidence_of_kept();
}

RefinedPose Submap::match(std::span<const Point2> points_base_link, const PosePrior& prior,
                          const Pose2& start) const {
  const Pose2 coarse = aligned_pose(field_, points_base_link, start,
                                    {.kernel_m = kCoarseKernel, .max_iterations = 6}, prior);
  return refine_pose(field_, points_base_link, coarse,
                     {.kernel_m = kFineKernel, .max_iterations = 6}, prior);
}

Eigen::Matrix3d Submap::match_information(std::span<const Point2> points_base_link,
                                          const Pose2& T_submap_base_link) const {
  constexpr std::size_t kPoints = 90;  // evenly thinned, each standing for its neighbours
  const std::vector<Point2> points = thinned(points_base_link, kPoints);
  const double weight = static_cast<double>(points_base_link.size()) /
                        static_cast<double>(std::max<std::size_t>(1, points.size()));
  const Eigen::Matrix3d information =
      observed_information(field_, points, T_submap_base_link,
                           {.kernel_m = kFineKernel, .normal_error_rad = kNormalError});
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_submap_base_link.yaw).toRotationMatrix();
  return weight * rotation.transpose() * information * rotation;
}

FoundStart Submap::search(std::span<const Point2> points_base_link, const Pose2& middle,
                          const SearchWindow& window) const {
  constexpr std::size_t kPoints = 60;
  constexpr double kShift = 0.15;        // about what match() mends with ease [m]
  constexpr double kTurn = 0.05;         // [rad]
  constexpr double kFar = 0.5;           // farther from a wall is no worse [m]
  constexpr double kCostOfShift = 0.05;  // [m^2/m^2]
  constexpr double kCostOfTurn = 0.2;    // [m^2/rad^2]
  std::vector<Point2> points = thinned(points_base_link, kPoints);
  const int shifts = static_cast<int>(std::lround(window.shift_m / kShift));
  const int turns = static_cast<int>(std::lround(window.turn_rad / kTurn));
  FoundStart best{middle, std::numeric_limits<double>::infinity()};
  std::vector<Point2> turned(points.size());
  for (int turn = -turns; turn <= turns; ++turn) {
    const Pose2 at_middle{middle.x, middle.y, wrap_angle(middle.yaw + kTurn * turn)};
    const Pose2 T_grid_base_link = field_.T_grid_frame() * at_middle;
    std::ranges::transform(points, turned.begin(),
                           [&](const Point2& p) { return T_grid_base_link * p; });
    for (int column = -shifts; column <= shifts; ++column) {
      for (int row = -shifts; row <= shifts; ++row) {
        const Point2 shift{kShift * column, kShift * row};
        double sum = 0.0;
        for (const Point2& p : turned) {
          const double d = std::min(kFar, field_.nearest(p + shift));
          sum += d * d;
        }
        const double cost = sum / static_cast<double>(points.size()) +
                            kCostOfShift * shift.squaredNorm() +
                            kCostOfTurn * (kTurn * turn) * (kTurn * turn);
        if (cost >= best.cost) continue;
        best = {{at_middle.x + shift.x(), at_middle.y + shift.y(), at_middle.yaw}, cost};
      }
    }
  }
  return best;
}

std::vector<SubmapScanPtr> Submap::scans() const {
  std::vector<SubmapScanPtr> scans;
  scans.reserve(kept_.size());
  for (const Kept& kept : kept_) scans.push_back(kept.scan);
  return scans;
}

std::vector<Pose2> Submap::poses() const {
  std::vector<Pose2> poses;
  poses.reserve(kept_.size());
  for (const Kept& kept : kept_) poses.push_back(kept.scan->T_submap_base_link);
  return poses;
}

}  // namespace cornerfix
