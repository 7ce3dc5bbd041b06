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
  std::array<int, kEndClasses> ends{};
  std::array<int, kPassClasses> passes{};
  for (const Point2& p : evidence.ends) ++ends[classes.end_class(column_of(p), row_of(p))];
  for (const Point2& p : evidence.free) ++passes[classes.pass_class(column_of(p), row_of(p))];

  EvidenceScore score{.ends = static_cast<int>(evidence.ends.size())};
  int matched = 0;
  int contradicted = 0;
  for (std::size_t i = 0; i < kEndClasses; ++i) {
    score.log_likelihood += static_cast<double>(kEndWeights[i]) * ends[i];
    if (i <= kLastMatchedClass) matched += ends[i];
    if (i >= kFirstContradictedClass && i <= kLastContradictedClass) contradicted += ends[i];
  }
  for (std::size_t i = 0; i < kPassClasses; ++i) {
    score.log_likelihood += static_cast<double>(kPassWeights[i]) * passes[i];
  }
  const double count = std::max(1.0, static_cast<double>(evidence.ends.size()));
  score.matched = matched / count;
  score.contradicted = contradicted / count;
  score.blocked = passes[static_cast<std::size_t>(PassClass::kOnWall)] /
                  std::max(1.0, static_cast<double>(evidence.free.size()));
  return score;
}

double probability_right(const EvidenceScore& best, double gap) {
  if (best.ends == 0 || gap <= 0.0) return 0.0;
  const double mean = best.log_likelihood / best.ends;
  const double z = -16.35 + 0.365 * std::sqrt(gap) + 3.64 * std::sqrt(gap / best.ends) +
                   0.85 * std::min(mean, 1.0) - 1.49 * std::log(best.contradicted + 0.02) -
                   2.28 * std::log(best.blocked + 0.02);
  return 1.0 / (1.0 + std::exp(-z));
}

}  // namespace cornerfix
