#include <gtest/gtest.h>

#include <numbers>

#include "core/src/slam/pose_graph.hpp"
#include "support/matchers.hpp"

namespace cornerfix {
namespace {

using testing::IsPoseNear;

constexpr std::size_t kPosesOfLoop = 40;

/// Once around a circle of 10 m, across the angle seam.
std::vector<Pose2> true_poses() {
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < kPosesOfLoop; ++i) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / kPosesOfLoop;
    poses.push_back({10.0 * std::cos(angle), 10.0 * std::sin(angle),
                     wrap_angle(angle + std::numbers::pi / 2.0)});
  }
  return poses;
}

PoseRelation relation(const std::vector<Pose2>& truth, std::size_t from, std::size_t to) {
  return {.from = from,
          .to = to,
          .T_from_to = inverse(truth[from]) * truth[to],
          .information = information_from(0.05, 0.01)};
}

/// Relations of neighbours, and poses that begin where a drifting odometry left them.
PoseGraph drifting_graph(const std::vector<Pose2>& truth) {
  PoseGraph graph{{truth.front()}, {}};
  for (std::size_t i = 1; i < truth.size(); ++i) {
    graph.relations.push_back(relation(truth, i - 1, i));
    graph.poses.push_back(graph.poses.back() * graph.relations.back().T_from_to *
                          Pose2{0.02, 0.01, 0.01});
  }
  return graph;
}

TEST(PoseGraph, FindsThePosesThatTheRelationsTell) {
  const std::vector<Pose2> truth = true_poses();
  PoseGraph graph = drifting_graph(truth);
  graph.relations.push_back(relation(truth, 0, kPosesOfLoop - 1));
  ASSERT_TRUE(optimize(graph));
  for (std::size_t i = 0; i < kPosesOfLoop; ++i)
    EXPECT_THAT(graph.poses[i], IsPoseNear(truth[i], 1e-4, 1e-5)) << i;
}

TEST(PoseGraph, LeavesTheFirstPoseWhereItIs) {
  const std::vector<Pose2> truth = true_poses();
  PoseGraph graph = drifting_graph(truth);
  graph.poses.front() = {100.0, -50.0, 3.0};
  ASSERT_TRUE(optimize(graph));
  EXPECT_EQ(graph.poses.front(), (Pose2{100.0, -50.0, 3.0}));
  EXPECT_THAT(inverse(graph.poses[0]) * graph.poses[7],
              IsPoseNear(inverse(truth[0]) * truth[7], 1e-4, 1e-5));
}

TEST(PoseGraph, SpreadsAContradictionOverTheLoop) {
  const std::vector<Pose2> truth = true_poses();
  PoseGraph graph = drifting_graph(truth);
  graph.poses = truth;
  PoseRelation closure = relation(truth, 0, kPosesOfLoop - 1);
  closure.T_from_to.x += 0.4;
  graph.relations.push_back(closure);
  ASSERT_TRUE(optimize(graph));
  double farthest = 0.0;
  for (std::size_t i = 1; i < kPosesOfLoop; ++i) {
    const Pose2 moved = inverse(graph.poses[i - 1]) * graph.poses[i];
    farthest = std::max(farthest, distance(moved, inverse(truth[i - 1]) * truth[i]));
  }
  EXPECT_GT(farthest, 0.001);
  EXPECT_LT(farthest, 0.05);
}

TEST(PoseGraph, IsHardlyBentByAFalseClosureThatMayBeWrong) {
  const std::vector<Pose2> truth = true_poses();
  const auto bent_by = [&](bool may_be_wrong) {
    PoseGraph graph = drifting_graph(truth);
    graph.poses = truth;
    for (const std::size_t from : {0, 2, 4, 6}) {
      PoseRelation closure = relation(truth, from, kPosesOfLoop - 1 - from);
      closure.may_be_wrong = true;
      graph.relations.push_back(closure);
    }
    PoseRelation wrong = relation(truth, 5, 25);
    wrong.T_from_to.x += 6.0;
    wrong.may_be_wrong = may_be_wrong;
    graph.relations.push_back(wrong);
    EXPECT_TRUE(optimize(graph));
    return distance(graph.poses[25], truth[25]);
  };
  EXPECT_GT(bent_by(false), 0.5);
  EXPECT_LT(bent_by(true), 0.1);
}

TEST(PoseGraph, LeavesPosesWithoutRelationsAlone) {
  PoseGraph graph{{Pose2{1, 2, 3}, Pose2{4, 5, 1}}, {}};
  ASSERT_TRUE(optimize(graph));
  EXPECT_EQ(graph.poses[1], (Pose2{4, 5, 1}));
}

TEST(PoseGraph, ReportsRelationsThatAreNoNumbers) {
  PoseGraph graph{{Pose2{}, Pose2{1, 0, 0}}, {}};
  graph.relations.push_back({.from = 0, .to = 1, .T_from_to = {std::nan(""), 0, 0}});
  const std::vector<Pose2> before = graph.poses;
  const Result<void> result = optimize(graph);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kInternal);
  EXPECT_EQ(graph.poses, before);
}

}  // namespace
}  // namespace cornerfix
