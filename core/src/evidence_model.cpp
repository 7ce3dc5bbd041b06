#include <cornerfix/evidence_model.hpp>

#include <algorithm>
#include <cmath>

namespace cornerfix {
namespace {

std::size_t end_class_of(double distance_m, Cell cell) {
  for (std::size_t i = 0; i < kNearLimits.size(); ++i) {
    if (distance_m < kNearLimits[i]) return i;
  }
  const std::size_t first = kNearLimits.size() + (cell == Cell::kUnknown ? kFarLimits.size() : 0);
  for (std::size_t i = 0; i + 1 < kFarLimits.size(); ++i) {
    if (distance_m < kFarLimits[i]) return first + i;
  }
  return first + kFarLimits.size() - 1;
}

PassClass pass_class_of(double distance_m, Cell cell) {
  constexpr double kNearWall = 0.15;
  if (cell == Cell::kOccupied) return PassClass::kOnWall;
  if (distance_m < kNearWall) return PassClass::kNearWall;
  return cell == Cell::kFree ? PassClass::kFree : PassClass::kUnknown;
}

/// Classes 2 and below are within 0.15 m of a wall.
constexpr std::size_t kLastMatchedClass = 2;
/// Known-free classes beyond 0.3 m.
constexpr std::size_t kFirstContradictedClass = kNearLimits.size() + 1;
constexpr std::size_t kLastContradictedClass = kNearLimits.size() + kFarLimits.size() - 1;

void summarise(EvidenceScore& score) {
  int matched = 0;
  int contradicted = 0;
  for (std::size_t i = 0; i < kEndClasses; ++i) {
    const int count = score.end_counts[i];
    score.ends += count;
    score.log_likelihood += static_cast<double>(kEndWeights[i]) * count;
    if (i <= kLastMatchedClass) matched += count;
    if (i >= kFirstContradictedClass && i <= kLastContradictedClass) contradicted += count;
  }
  int passes = 0;
  for (std::size_t i = 0; i < kPassClasses; ++i) {
    passes += score.pass_counts[i];
    score.log_likelihood += static_cast<double>(kPassWeights[i]) * score.pass_counts[i];
  }
  const double ends = std::max(1.0, static_cast<double>(score.ends));
  score.matched = matched / ends;
  score.contradicted = contradicted / ends;
  score.blocked = score.pass_counts[static_cast<std::size_t>(PassClass::kOnWall)] /
                  std::max(1.0, static_cast<double>(passes));
}

}  // namespace

ClassField::ClassField(const OccupancyGrid& grid, const DistanceField& field)
    : T_grid_map_(inverse(grid.T_map_grid)),
      resolution_(grid.resolution),
      width_(grid.width),
      height_(grid.height),
      classes_(grid.cells.size()) {
  for (std::size_t i = 0; i < classes_.size(); ++i) {
    const double distance_m = DistanceField::kStep * static_cast<double>(field.steps()[i]);
    const auto pass = static_cast<std::size_t>(pass_class_of(distance_m, grid.cells[i]));
    classes_[i] = static_cast<std::uint8_t>(end_class_of(distance_m, grid.cells[i]) | (pass << 4U));
  }
}

EvidenceScore score_evidence(const ClassField& classes, const Evidence& evidence,
                             const Pose2& T_map_evidence) {
  const Pose2 T = classes.T_grid_map() * T_map_evidence;
  const double scale = 1.0 / classes.resolution();
  const double c = std::cos(T.yaw) * scale;
  const double s = std::sin(T.yaw) * scale;
  const double x = T.x * scale;
  const double y = T.y * scale;
  const auto column_of = [&](const Point2& p) {
    return static_cast<int>(std::floor(x + c * p.x() - s * p.y()));
  };
  const auto row_of = [&](const Point2& p) {
    return static_cast<int>(std::floor(y + s * p.x() + c * p.y()));
  };
  EvidenceScore score;
  for (const Point2& p : evidence.ends)
    ++score.end_counts[classes.end_class(column_of(p), row_of(p))];
  for (const Point2& p : evidence.free)
    ++score.pass_counts[classes.pass_class(column_of(p), row_of(p))];
  summarise(score);
  return score;
}

double probability_right(const EvidenceScore& best, double gap) {
  if (best.ends == 0 || gap <= 0.0) return 0.0;
  const double mean = best.log_likelihood / best.ends;
  const double z = -16.76 + 0.526 * std::sqrt(gap) + 0.644 * std::sqrt(gap / best.ends) +
                   0.975 * std::min(mean, 1.0) - 1.740 * std::log(best.contradicted + 0.02) -
                   2.105 * std::log(best.blocked + 0.02);
  return 1.0 / (1.0 + std::exp(-z));
}

}  // namespace cornerfix
