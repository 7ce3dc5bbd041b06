#include "core/src/acceptance/new_ground.hpp"

#include <cmath>

namespace cornerfix {
namespace {

constexpr double kCell = 0.5;       // [m]
constexpr int kMinHits = 40;        // on new ground
constexpr double kAgreeing = 0.65;  // share of the hits that the map explains
constexpr double kContradicting = 0.45;

std::uint64_t cell_of(const Point2& p) {
  const auto column = static_cast<std::int32_t>(std::floor(p.x() / kCell));
  const auto row = static_cast<std::int32_t>(std::floor(p.y() / kCell));
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(column)) << 32U) |
         static_cast<std::uint32_t>(row);
}

}  // namespace

NewGround::NewGround(const Evidence& accepted) {
  for (const Point2& hit : accepted.ends) old_cells_.insert(cell_of(hit));
}

NewGround::Verdict NewGround::judge(const ClassField& classes, const Evidence& seen,
                                    const Pose2& T_map_submap) const {
  Evidence fresh;
  for (std::size_t i = 0; i < seen.ends.size(); ++i) {
    if (old_cells_.contains(cell_of(seen.ends[i]))) continue;
    fresh.ends.push_back(seen.ends[i]);
    if (!seen.origins.empty()) fresh.origins.push_back(seen.origins[i]);
  }
  const EvidenceScore score = score_evidence(classes, fresh, T_map_submap);
  if (judged_hits(score) < kMinHits) return Verdict::kUndecided;
  const double share = explained_share(score);
  if (share >= kAgreeing) return Verdict::kAgrees;
  return share < kContradicting ? Verdict::kContradicts : Verdict::kUndecided;
}

}  // namespace cornerfix
