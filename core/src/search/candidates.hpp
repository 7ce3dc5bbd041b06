/// \file  The places where the robot may be, and whether the best of them is sure.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <cornerfix/answer.hpp>
#include <cornerfix/localization_map.hpp>
#include <cornerfix/localizer_params.hpp>
#include <cornerfix/pose2.hpp>

#include "core/src/acceptance/acceptance.hpp"
#include "core/src/local_map/view.hpp"
#include "core/src/map/evidence_model.hpp"

namespace cornerfix {

/// Mean log-likelihood below the best, a hit, at which a rival cannot matter [nat].
inline constexpr double kRivalMargin = 0.75;

struct Candidate {
  std::size_t map = 0;  ///< Into the maps asked.
  Pose2 T_map_base_link;
  int votes = 0;    ///< Of the descriptors that proposed it, if they did.
  int inliers = 0;  ///< Features that agreed with them.
  EvidenceScore score{};
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

  /// Known-free space of all maps searched [m^2]: how many poses there are to be mistaken for.
  void set_free_area(double free_area_m2) { free_area_m2_ = free_area_m2; }

  /// Maps that may hold the robot and were not searched. Each counts as a rival as good as the best
  /// candidate.
  void set_unsearched_maps(std::size_t count) { unsearched_maps_ = count; }
  /// `new_index` by the index before.
  void renumber_maps(std::span<const std::size_t> new_index) {
    for (Candidate& place : places_) place.map = new_index[place.map];
  }

  // The following ask for a best candidate. Rivals more than `depth` nat per hit below it were not
  // searched for, and are assumed to exist.

  /// What the decision weighs.
  [[nodiscard]] AcceptanceTerms terms(double depth) const;
  /// The same if there were no rivals within `depth`.
  [[nodiscard]] AcceptanceTerms terms_without_rivals(double depth) const;
  /// Whether the best may be accepted.
  [[nodiscard]] bool acceptable(double depth) const;
  /// Whether it would be if there were no other poses than those known.
  [[nodiscard]] bool may_be_accepted() const { return acceptable(kRivalMargin); }
  /// Whether the best would be accepted if no map were unsearched.
  [[nodiscard]] bool is_only_unsearched(double depth) const;
  /// What would be missing if there were no rivals; kNone when only these stand in the way.
  [[nodiscard]] Reason missing_without_rivals() const;

 private:
  [[nodiscard]] bool acceptable(const AcceptanceTerms& terms) const;
  [[nodiscard]] AcceptanceTerms terms(double depth, std::size_t unsearched_maps) const;
  /// All but the best.
  [[nodiscard]] std::vector<OtherPose> other_poses() const;
  [[nodiscard]] double margin(double depth) const;
  [[nodiscard]] double margin_without_rivals(double depth) const;
  Candidate* find(std::size_t map, const Pose2& T_map_base_link);

  AcceptanceParams acceptance_;
  std::vector<Candidate> places_;
  double free_area_m2_ = 0.0;
  std::size_t unsearched_maps_ = 0;
};

}  // namespace cornerfix
