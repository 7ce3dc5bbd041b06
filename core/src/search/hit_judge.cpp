#include "core/src/search/hit_judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "core/src/base/thinned.hpp"
#include "core/src/base/within.hpp"

namespace cornerfix {
namespace {

constexpr std::size_t kHits = 96;
constexpr std::size_t kFirstHits = 8;  // after which a hopeless pose is given up
constexpr double kHopeless = -0.35;    // mean weight of the first hits [nat]

// Weight of a hit by HitLevel [nat]; as in the search, optimistic by the width of a cell.
constexpr std::array<float, 4> kLevelWeights{-1.1F, -0.47F, -0.10F, 0.41F};

HitLevel level_at(const MapSketch& sketch, double x, double y) {
  return sketch.level(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
}

}  // namespace

HitJudge::HitJudge(std::span<const Point2> hits) {
  const std::vector<Point2> some = thinned(within(hits, kCoarseReach), kHits);
  constexpr std::size_t kStep = kHits / kFirstHits;
  hits_.reserve(some.size());
  for (std::size_t first = 0; first < kStep; ++first) {
    for (std::size_t i = first; i < some.size(); i += kStep) hits_.push_back(some[i]);
  }
}

std::optional<double> HitJudge::mean_at(const MapSketch& sketch, const Pose2& pose) const {
  const double c = std::cos(pose.yaw) / sketch.cell_m;
  const double s = std::sin(pose.yaw) / sketch.cell_m;
  const double x = pose.x / sketch.cell_m;
  const double y = pose.y / sketch.cell_m;
  if (level_at(sketch, x, y) == HitLevel::kUnknown) return std::nullopt;
  const auto sum_of = [&](std::span<const Point2> hits) {
    float sum = 0.0F;
    for (const Point2& p : hits) {
      const HitLevel level = level_at(sketch, x + c * p.x() - s * p.y(), y + s * p.x() + c * p.y());
      sum += kLevelWeights[static_cast<std::size_t>(level)];
    }
    return static_cast<double>(sum);
  };
  const std::span<const Point2> all = hits_;
  const std::size_t first = std::min(kFirstHits, all.size());
  const double sum = sum_of(all.first(first));
  if (sum < kHopeless * static_cast<double>(first)) return std::nullopt;
  return (sum + sum_of(all.subspan(first))) / static_cast<double>(all.size());
}

std::pair<double, Pose2> HitJudge::refined(const MapSketch& sketch, double mean, Pose2 pose) const {
  constexpr int kMaxRounds = 6;
  constexpr double kTurn = 0.025;  // [rad]
  const double step = sketch.cell_m / 2.0;
  const std::array<Pose2, 6> moves{Pose2{step, 0.0, 0.0},  Pose2{-step, 0.0, 0.0},
                                   Pose2{0.0, step, 0.0},  Pose2{0.0, -step, 0.0},
                                   Pose2{0.0, 0.0, kTurn}, Pose2{0.0, 0.0, -kTurn}};
  for (int round = 0; round < kMaxRounds; ++round) {
    const Pose2 from = pose;
    for (const Pose2& move : moves) {
      const Pose2 moved = from * move;
      const auto there = mean_at(sketch, moved);
      if (there && *there > mean) std::tie(mean, pose) = std::tie(*there, moved);
    }
    if (pose == from) break;
  }
  return {mean, pose};
}

}  // namespace cornerfix
