/// \file  The places where the robot may be, and whether the best of them is sure.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/evidence_model.hpp>
#include <cornerfix/localizer.hpp>
#include <cornerfix/localizer_params.hpp>
#include <cornerfix/pose2.hpp>

#include "view.hpp"

namespace cornerfix {

/// Mean log-likelihood below the best, a beam end, at which a rival cannot matter [nat].
inline constexpr double kRivalMargin = 0.75;

struct Candidate {
  std::size_t map = 0;  ///< Into the maps asked.
  Pose2 T_map_base_link;
  int votes = 0;    ///< Of the descriptors that proposed it, if they did.
  int inliers = 0;  ///< Features that agreed with them.
  EvidenceScore score;
};

/// Distinct places, the one that fits best first.
class Candidates {
 public:
  static constexpr std::size_t kMaxPlaces = 12;

  explicit Candidates(AcceptanceParams acceptance = {}) : acceptance_(acceptance) {}

  [[nodiscard]] std::span<const Candidate> all() const { return places_; }
  [[nodiscard]] bool empty() const { return places_.empty(); }
  /// Not when empty.
  [[nodiscard]] const Candidate& best() const { return places_.front(); }

  void clear() { places_.clear(); }
  /// After the robot moved on.
  void move_along(const Pose2& motion);
  /// Refines and scores a candidate; of those at one place the best stays.
  void consider(const LocalizationMap& map, const View& view, Candidate candidate);
  /// Refines and scores all anew, by what has been seen since.
  void judge_again(std::span<const LocalizationMapPtr> maps, const View& view);
  [[nodiscard]] bool knows(std::size_t map, const Pose2& T_map_base_link) const;

  // The following ask for a best candidate.

  /// Log-likelihood of the best less that of the best other place [nat], or, when that is none,
  /// less that of one which `margin`, a beam end, would just have left out.
  [[nodiscard]] double gap(double margin) const;
  /// Gap when there is no other place within `margin`, a beam end.
  [[nodiscard]] double gap_without_rivals(double margin) const;
  /// Whether the best may be a fix by such a gap.
  [[nodiscard]] bool acceptable(double gap) const;
  /// Gap at which it would be one if that probability were asked for.
  [[nodiscard]] double needed_gap(double probability) const;
  /// Whether it would be one if there were no other places than those known.
  [[nodiscard]] bool may_be_fix() const { return acceptable(gap(kRivalMargin)); }
  /// What would be missing if there were no other place; kNone when only that stands in the way.
  [[nodiscard]] Reason missing_without_rivals() const;

 private:
  Candidate* find(std::size_t map, const Pose2& T_map_base_link);

  AcceptanceParams acceptance_;
  std::vector<Candidate> places_;
};

}  // namespace cornerfix
