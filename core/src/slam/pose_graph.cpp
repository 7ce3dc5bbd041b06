#include "core/src/slam/pose_graph.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace cornerfix {
namespace {

/// Deviation, in standard deviations, from which on a doubtful relation pulls less and less.
constexpr double kRobustScale = 2.0;

/// Difference between a relation and the poses that it relates, whitened by its information.
class RelationError final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  explicit RelationError(const PoseRelation& relation)
      : T_from_to_(relation.T_from_to), root_(relation.information.llt().matrixU()) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Pose2 from{parameters[0][0], parameters[0][1], parameters[0][2]};
    const Pose2 to{parameters[1][0], parameters[1][1], parameters[1][2]};
    const double c = std::cos(from.yaw);
    const double s = std::sin(from.yaw);
    const Eigen::Vector2d offset = to.translation() - from.translation();
    const Eigen::Vector2d seen{c * offset.x() + s * offset.y(), -s * offset.x() + c * offset.y()};
    Eigen::Map<Eigen::Vector3d>{residuals} =
        root_ * Eigen::Vector3d{seen.x() - T_from_to_.x, seen.y() - T_from_to_.y,
                                wrap_angle(to.yaw - from.yaw - T_from_to_.yaw)};
    if (jacobians == nullptr) return true;
    using Jacobian = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    Eigen::Matrix3d by_to = Eigen::Matrix3d::Identity();
    by_to.topLeftCorner<2, 2>() << c, s, -s, c;
    if (jacobians[1] != nullptr) Eigen::Map<Jacobian>{jacobians[1]} = root_ * by_to;
    if (jacobians[0] != nullptr) {
      Eigen::Matrix3d by_from = -by_to;
      by_from(0, 2) = seen.y();
      by_from(1, 2) = -seen.x();
      Eigen::Map<Jacobian>{jacobians[0]} = root_ * by_from;
    }
    return true;
  }

 private:
  Pose2 T_from_to_;
  Eigen::Matrix3d root_;
};

using Parameters = std::array<double, 3>;

void add_relations(ceres::Problem& problem, const PoseGraph& graph,
                   std::vector<Parameters>& values) {
  for (const PoseRelation& relation : graph.relations) {
    assert(relation.from != relation.to && relation.from < values.size() &&
           relation.to < values.size() && "a relation joins two poses of the graph");
    ceres::LossFunction* loss =
        relation.may_be_wrong ? new ceres::CauchyLoss(kRobustScale) : nullptr;  // owned by problem
    problem.AddResidualBlock(new RelationError(relation), loss, values[relation.from].data(),
                             values[relation.to].data());
  }
  if (problem.HasParameterBlock(values.front().data()))
    problem.SetParameterBlockConstant(values.front().data());
}

bool is_finite(const Parameters& value) {
  return std::all_of(value.begin(), value.end(), [](double x) { return std::isfinite(x); });
}

/// The solver would print what it thinks of relations that are no numbers.
bool all_finite(const std::vector<PoseRelation>& relations) {
  return std::all_of(relations.begin(), relations.end(), [](const PoseRelation& relation) {
    const Pose2& T = relation.T_from_to;
    return is_finite({T.x, T.y, T.yaw}) && relation.information.allFinite();
  });
}

}  // namespace

Eigen::Matrix3d information_from(double sigma_position_m, double sigma_yaw_rad) {
  const double position = 1.0 / (sigma_position_m * sigma_position_m);
  return Eigen::Vector3d{position, position, 1.0 / (sigma_yaw_rad * sigma_yaw_rad)}.asDiagonal();
}

Result<void> optimize(PoseGraph& graph, int max_iterations) {
  if (graph.relations.empty()) return {};
  if (!all_finite(graph.relations))
    return Error{ErrorCode::kInternal, "a relation is not finite", "pose_graph"};
  std::vector<Parameters> values;
  values.reserve(graph.poses.size());
  for (const Pose2& pose : graph.poses) values.push_back({pose.x, pose.y, pose.yaw});
  ceres::Problem problem;
  add_relations(problem, graph, values);

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.num_threads = 1;  // The order of sums must not depend on the machine.
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable() || !std::all_of(values.begin(), values.end(), is_finite)) {
    return Error{ErrorCode::kInternal, "no poses agree with the relations: " + summary.message,
                 "pose_graph"};
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    graph.poses[i] = {values[i][0], values[i][1], wrap_angle(values[i][2])};
  return {};
}

}  // namespace cornerfix
