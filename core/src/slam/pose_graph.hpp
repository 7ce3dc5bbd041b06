/// \file  Poses that agree best with all relative poses measured between them: pose graph
/// optimisation.
///
/// Sparse nonlinear least squares; relations that may be wrong get a robust loss, so that one false
/// loop closure bends the graph only a little. After Grisetti et al. 2010, "A Tutorial on
/// Graph-Based SLAM".
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix {

/// A measured relative pose between two poses of a graph.
struct PoseRelation {
  std::size_t from = 0;  ///< Index of a pose of the graph; not `to`.
  std::size_t to = 0;
  Pose2 T_from_to;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< Of x, y, yaw in `from`; positive
                                                              ///< definite.
  bool may_be_wrong = false;  ///< A robust loss then bounds its pull.
};

struct PoseGraph {
  std::vector<Pose2> poses;  ///< In one frame; where the search begins.
  std::vector<PoseRelation> relations;
};

/// The diagonal information of independent standard deviations [m, rad], both > 0.
[[nodiscard]] Eigen::Matrix3d information_from(double sigma_position_m, double sigma_yaw_rad);

/// Moves the poses; the first one stays. kInternal when a relation is not finite or no finite
/// solution was found, and the poses are then what they were. Deterministic. A graph without
/// relations is left as it is.
[[nodiscard]] Result<void> optimize(PoseGraph& graph, int max_iterations = 50);

}  // namespace cornerfix
