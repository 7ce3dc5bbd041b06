/// \file  Whether the best pose of a search may be trusted: the calibrated probability that it is
/// correct.
///
/// Three conditions must hold, and each has its own logistic model. The pose must explain the scans
/// by itself, better than the best of all poses in the map would by chance (an a-contrario test:
/// Desolneux, Moisan, Morel 2000). Every other pose must explain them worse by a margin per hit.
/// And that margin must be significant against each rival (a test of non-nested models after Vuong
/// 1989, with blocks of the local map as independent samples). The probability is the product: a
/// large margin over rivals does not excuse a pose that explains nothing. Coefficients:
/// docs/method/05-acceptance.md.
#pragma once

#include <span>

#include <cornerfix/answer.hpp>

#include "core/src/map/evidence_model.hpp"

namespace cornerfix {

/// The margin over a rival in units of its standard error: the sum of the differences of blocks,
/// divided by the root of the sum of their squares. 0 without blocks.
[[nodiscard]] double margin_z(const EvidenceScore& best, const EvidenceScore& rival);

/// Negative logarithm of the expected number of poses that explain as many independent hits by
/// chance [nat]. It is the independent hits times the relative entropy of the explained share,
/// minus the logarithm of the number of distinct poses in `free_area_m2`.
[[nodiscard]] double chance_significance(const EvidenceScore& best, double free_area_m2);

/// \param margin  Log-likelihood of the best less that of the strongest rival [nat].
/// \param rival_z  margin_z() of each rival.
/// \param free_area_m2  Known-free space of all maps searched.
/// Terms are clamped to the range of the calibration data where extrapolation would raise the
/// probability.
[[nodiscard]] AcceptanceTerms weigh(const EvidenceScore& best, double margin,
                                    std::span<const double> rival_z, double free_area_m2);

/// The margin [nat] at which the probability reaches `probability` without rivals; infinite when no
/// margin suffices.
[[nodiscard]] double margin_for(const EvidenceScore& best, double free_area_m2, double probability);

}  // namespace cornerfix
