#include "core/src/map/evidence_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

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

// A place of a class is at least this far from a wall [m].
constexpr std::array<double, kFieldClasses> kClassClearance{0.0, 0.05, 0.10, 0.15, 0.20, 0.30,
                                                            0.5, 1.0,  0.20, 0.30, 0.5,  1.0};

// Ranges of classes, the last one not included.
constexpr std::size_t kEndOfMatched = 3;  // within 0.15 m of a wall
constexpr std::size_t kFirstContradicted = kNearLimits.size() + 1;
constexpr std::size_t kFirstUnmapped = kNearLimits.size() + kFarLimits.size();

double share(const EvidenceScore& score, std::size_t first, std::size_t end) {
  const auto counts = score.end_counts.begin();
  const int count = std::accumulate(counts + static_cast<std::ptrdiff_t>(first),
                                    counts + static_cast<std::ptrdiff_t>(end), 0);
  return static_cast<double>(count) / std::max(1, score.ends);
}

void summarise(EvidenceScore& score) {
  for (std::size_t i = 0; i < kEndClasses; ++i) {
    score.ends += score.end_counts[i];
    score.fit += static_cast<double>(kSearchWeights.ends[i]) * score.end_counts[i];
    score.log_likelihood += static_cast<double>(kRivalWeights.ends[i]) * score.end_counts[i];
  }
  for (std::size_t i = 0; i < kPassClasses; ++i) {
    score.fit += static_cast<double>(kSearchWeights.passes[i]) * score.pass_counts[i];
    score.log_likelihood += static_cast<double>(kRivalWeights.passes[i]) * score.pass_counts[i];
  }
  score.matched = share(score, 0, kEndOfMatched);
  score.contradicted = share(score, kFirstContradicted, kFirstUnmapped);
  score.unmapped = share(score, kFirstUnmapped, kFieldClasses);
}

/// Takes points of the evidence into cells of the map's grid.
class ToCells {
 public:
  ToCells(const ClassField& classes, const Pose2& T_map_evidence) {
    const Pose2 T = classes.T_grid_map() * T_map_evidence;
    const double scale = 1.0 / classes.resolution();
    c_ = std::cos(T.yaw) * scale;
    s_ = std::sin(T.yaw) * scale;
    x_ = T.x * scale;
    y_ = T.y * scale;
  }
  Point2 operator()(const Point2& p) const {
    return {x_ + c_ * p.x() - s_ * p.y(), y_ + s_ * p.x() + c_ * p.y()};
  }

 private:
  double c_;
  double s_;
  double x_;
  double y_;
};

std::string end_class_name(std::size_t end_class) {
  static constexpr std::array<const char*, kNearLimits.size()> kNear{"0.05", "0.10", "0.15",
                                                                     "0.20"};
  static constexpr std::array<const char*, kFarLimits.size()> kFar{"0.30", "0.50", "1.00", "far"};
  if (end_class == kHiddenNear) return "hidden_near_wall";
  if (end_class == kHiddenFar) return "hidden";
  if (end_class < kNear.size()) return std::string("wall_") + kNear[end_class];
  const std::size_t far = end_class - kNear.size();
  return std::string(far < kFar.size() ? "free_" : "unknown_") + kFar[far % kFar.size()];
}

std::string pass_class_name(std::size_t pass_class) {
  static constexpr std::array<const char*, kPassClasses> kNames{"on_wall", "near_wall", "free",
                                                                "unknown"};
  return kNames[pass_class];
}

template <std::size_t N, typename Name>
std::vector<EvidenceClass> classes_of(const std::array<int, N>& counts,
                                      const std::array<float, N>& weights, const Name& name) {
  std::vector<EvidenceClass> classes;
  for (std::size_t i = 0; i < N; ++i) {
    if (counts[i] == 0) continue;
    classes.push_back({name(i), counts[i], static_cast<double>(weights[i]) * counts[i]});
  }
  return classes;
}

}  // namespace

ClassField::ClassField(const OccupancyGrid& grid, const DistanceField& field)
    : T_grid_map_(inverse(grid.T_map_grid)),
      resolution_(grid.resolution),
      width_(grid.width),
      height_(grid.height),
      classes_(grid.cells.size()) {
  for (std::size_t i = 0; i < stride_.size(); ++i)
    stride_[i] = std::max(0.7, kClassClearance[i] / resolution_);
  for (std::size_t i = 0; i < classes_.size(); ++i) {
    const double distance_m = DistanceField::kStep * static_cast<double>(field.steps()[i]);
    const auto pass = static_cast<std::size_t>(pass_class_of(distance_m, grid.cells[i]));
    classes_[i] = static_cast<std::uint8_t>(end_class_of(distance_m, grid.cells[i]) | (pass << 4U));
  }
}

void ClassField::step(Walk& walk) const {
  constexpr double kClear = 0.20;
  const std::uint8_t here = packed(Point2(walk.from + walk.along * walk.direction));
  walk.has_left = walk.has_entered && kClassClearance[here & 15U] >= kClear;
  walk.has_entered |= (here >> 4U) == static_cast<std::size_t>(PassClass::kOnWall);
  walk.along += stride_[here & 15U];
}

/// Each step of a beam waits for the cell of the step before. So beams are walked side by side.
std::vector<std::uint8_t> ClassField::are_crossed(std::span<const Point2> from_cells,
                                                  std::span<const Point2> to_cells) const {
  constexpr std::size_t kAtOnce = 8;
  std::vector<std::uint8_t> are_crossed(to_cells.size(), 0);
  std::vector<Walk> walks;
  walks.reserve(kAtOnce);
  for (std::size_t begin = 0; begin < to_cells.size(); begin += kAtOnce) {
    const std::size_t end = std::min(to_cells.size(), begin + kAtOnce);
    walks.clear();
    for (std::size_t i = begin; i < end; ++i) walks.emplace_back(from_cells[i], to_cells[i]);
    for (bool are_done = false; !are_done;) {
      are_done = true;
      for (Walk& walk : walks) {
        if (walk.is_done()) continue;
        step(walk);
        are_done = false;
      }
    }
    for (std::size_t i = begin; i < end; ++i) are_crossed[i] = walks[i - begin].has_left ? 1 : 0;
  }
  return are_crossed;
}

std::vector<std::uint8_t> ClassField::walls_between(std::span<const Point2> from_cells,
                                                    std::span<const Point2> to_cells) const {
  constexpr double kGrazing = 0.1;  // [m]
  std::vector<std::uint8_t> are_blocked = are_crossed(from_cells, to_cells);
  std::vector<std::size_t> doubtful;
  std::vector<Point2> from_aside;  // To one side and to the other in turn.
  std::vector<Point2> to_aside;
  for (std::size_t i = 0; i < are_blocked.size(); ++i) {
    if (are_blocked[i] == 0) continue;
    const Point2 beam = to_cells[i] - from_cells[i];
    const Point2 aside =
        kGrazing / (resolution_ * std::max(beam.norm(), 1e-9)) * Point2{-beam.y(), beam.x()};
    doubtful.push_back(i);
    for (const Point2& shift : {aside, Point2(-aside)}) {
      from_aside.emplace_back(from_cells[i] + shift);
      to_aside.emplace_back(to_cells[i] + shift);
    }
  }
  const std::vector<std::uint8_t> beside = are_crossed(from_aside, to_aside);
  for (std::size_t i = 0; i < doubtful.size(); ++i) {
    const bool is_blocked = beside[2 * i] != 0 && beside[2 * i + 1] != 0;
    are_blocked[doubtful[i]] = is_blocked ? 1 : 0;
  }
  return are_blocked;
}

std::vector<std::uint8_t> hit_classes(const ClassField& classes, const Evidence& evidence,
                                      const Pose2& T_map_evidence) {
  const ToCells to_cells(classes, T_map_evidence);
  std::vector<Point2> ends(evidence.ends.size());
  std::ranges::transform(evidence.ends, ends.begin(), to_cells);
  std::vector<Point2> origins(evidence.origins.size());
  std::ranges::transform(evidence.origins, origins.begin(), to_cells);
  const std::vector<std::uint8_t> is_hidden = origins.empty()
                                                  ? std::vector<std::uint8_t>(ends.size(), 0)
                                                  : classes.walls_between(origins, ends);
  std::vector<std::uint8_t> hits(ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    std::size_t end_class = classes.packed(ends[i]) & 15U;
    if (is_hidden[i] != 0) end_class = end_class < kNearLimits.size() ? kHiddenNear : kHiddenFar;
    hits[i] = static_cast<std::uint8_t>(end_class);
  }
  return hits;
}

bool is_explained(std::size_t end_class) { return end_class < kEndOfMatched; }

EvidenceScore score_evidence(const ClassField& classes, const Evidence& evidence,
                             const Pose2& T_map_evidence) {
  EvidenceScore score;
  score.block_llr.assign(evidence.blocks, 0.0F);
  score.independent_hits = evidence.independent_hits;
  const std::vector<std::uint8_t> hits = hit_classes(classes, evidence, T_map_evidence);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    ++score.end_counts[hits[i]];
    if (!evidence.end_blocks.empty())
      score.block_llr[evidence.end_blocks[i]] += kRivalWeights.ends[hits[i]];
  }
  const ToCells to_cells(classes, T_map_evidence);
  for (std::size_t i = 0; i < evidence.free.size(); ++i) {
    const std::size_t pass_class = classes.packed(to_cells(evidence.free[i])) >> 4U;
    ++score.pass_counts[pass_class];
    if (!evidence.free_blocks.empty())
      score.block_llr[evidence.free_blocks[i]] += kRivalWeights.passes[pass_class];
  }
  summarise(score);
  return score;
}

int judged_hits(const EvidenceScore& score) {
  const auto count = [&](std::size_t first, std::size_t end) {
    const auto counts = score.end_counts.begin();
    return std::accumulate(counts + static_cast<std::ptrdiff_t>(first),
                           counts + static_cast<std::ptrdiff_t>(end), 0);
  };
  return count(0, kEndOfMatched) + count(kFirstContradicted, kFirstUnmapped) +
         count(kFieldClasses, kEndClasses);
}

double explained_share(const EvidenceScore& score) {
  const int judged = judged_hits(score);
  if (judged == 0) return 1.0;
  return share(score, 0, kEndOfMatched) * std::max(1, score.ends) / judged;
}

std::vector<EvidenceClass> hits_by_class(const EvidenceScore& score) {
  return classes_of(score.end_counts, kRivalWeights.ends, end_class_name);
}

std::vector<EvidenceClass> misses_by_class(const EvidenceScore& score) {
  return classes_of(score.pass_counts, kRivalWeights.passes, pass_class_name);
}

}  // namespace cornerfix
