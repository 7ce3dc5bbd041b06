/// \file  What a robot saw after its pose was accepted, and whether the map agrees with it.
///
/// A wrong pose is accepted because it explains what was seen until then. What is seen later, in
/// cells without evidence at the acceptance, is independent of that decision.
#pragma once

#include <cstdint>
#include <unordered_set>

#include <cornerfix/pose2.hpp>

#include "core/src/map/evidence_model.hpp"
#include "core/src/scan/evidence_grid.hpp"

namespace cornerfix {

/// Value type.
class NewGround {
 public:
  enum class Verdict {
    kUndecided,    ///< Too little was seen on new ground.
    kAgrees,       ///< The map explains most of it.
    kContradicts,  ///< The map contradicts most of it.
  };

  NewGround() = default;
  /// Everything in `accepted`, in the frame of the submap, is old ground.
  explicit NewGround(const Evidence& accepted);

  /// Judges the evidence outside of the old ground at a pose. O(hits).
  [[nodiscard]] Verdict judge(const ClassField& classes, const Evidence& seen,
                              const Pose2& T_map_submap) const;

 private:
  std::unordered_set<std::uint64_t> old_cells_;
};

}  // namespace cornerfix
