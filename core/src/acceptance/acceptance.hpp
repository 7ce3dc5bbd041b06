/// \file  Whether the best pose of a search may be trusted: the calibrated probability that it is
/// correct.
///
/// Two conditions must hold. The pose must explain the scans by itself, better than the best of all
/// poses in the map would by chance (an a-contrario test: Desolneux, Moisan, Morel 2000). And it
/// must explain them better than every other pose in most of the blocks in which the two differ.
/// That is a sign test with an unknown rate of changes and an estimated rate of coincidences. The
/// probability is the product: a large margin over rivals does not excuse a pose that explains
/// nothing. Derivation and calibration: docs/method/05-acceptance.md.
#pragma once

#include <span>

#include <cornerfix/answer.hpp>

#include "core/src/map/evidence_model.hpp"

namespace cornerfix {

/// Another candidate than the two that are compared.
struct OtherPose {
  const EvidenceScore* score = nullptr;
  /// Whether it has the heading of the best pose and its map. Where the building repeats, such
  /// poses are copies of the place.
  bool is_shifted = false;
};

/// Logarithm of the odds that the best pose is correct and not the rival, by the blocks in which
/// they differ [nat]. Each block that differs favours one of the poses. A block favours the wrong
/// pose when what stands there has changed and matches that pose by coincidence. The probability of
/// a change is unknown, uniformly distributed below one half. That of the coincidence is estimated
/// per block, by the other poses that the block matches and by the blocks that favour the rival; it
/// counts up to one half. Blocks count by their effective number, as in
/// EvidenceScore::independent_hits. 0 without differences. O(blocks * others).
/// \param others  All other poses; the rival may be among them. A block counts by the share of the
/// shifted ones that do not match it, because stock, doors and furniture match by chance in as many
/// copies of the place.
[[nodiscard]] double rival_log_odds(const EvidenceScore& best, const EvidenceScore& rival,
                                    std::span<const OtherPose> others = {});

/// Negative logarithm of the expected number of poses that explain as many independent hits by
/// chance [nat]. It is the independent hits times the relative entropy of the explained share,
/// minus the logarithm of the number of distinct poses in `free_area_m2`.
[[nodiscard]] double chance_significance(const EvidenceScore& best, double free_area_m2);

/// \param margin  Log-likelihood of the best less that of the strongest rival [nat].
/// \param log_odds  rival_log_odds() of each rival.
/// \param free_area_m2  Known-free space of all maps searched.
/// Terms are clamped to the range of the calibration data where extrapolation would raise the
/// probability. Without a positive margin the probability is 0.
[[nodiscard]] AcceptanceTerms weigh(const EvidenceScore& best, double margin,
                                    std::span<const double> log_odds, double free_area_m2);

/// Whether the pose explains more than two straight lines of hits. Two walls that are not parallel
/// fix a pose in every building that has two such walls, so they do not show that this is the right
/// building. Without the hits on the two longest lines that are explained, the explained share must
/// be above that of a pose that fits by chance. `T_map_evidence` takes the evidence's frame into
/// `map`. Cost as of hit_classes() and are_on_longest_lines().
[[nodiscard]] bool explains_more_than_two_lines(const ClassField& classes, const Evidence& evidence,
                                                const Pose2& T_map_evidence);

}  // namespace cornerfix
