#include "core/src/acceptance/acceptance.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/SpecialFunctions>

namespace cornerfix {
namespace {

// The share of hits that the best of some poses near a random one explains.
constexpr double kChanceShare = 0.2;
// Distinct poses per square metre of free space: 0.5 m apart, 24 headings.
constexpr double kPosesPerSquareMetre = 100.0;

// Limits of the significance that the calibration data cover [nat].
constexpr double kMostSignificance = 15.0;
constexpr double kLeastSignificance = -25.0;
// Evidence against rivals without any rival, and with many as good as the best [nat]. About 900
// accepted samples without a wrong one support no higher probability than that of the first.
constexpr double kMostRivalEvidence = 7.0;
constexpr double kLeastRivalEvidence = -3.0;

// Coefficients of the logistic model of the significance. By theory its slope is 1, because the
// significance is a logarithm of odds. The data prefer 0.8.
constexpr double kExplainedOffset = 5.7;
constexpr double kExplainedSlope = 0.8;

double logistic(double x) { return 1.0 / (1.0 + std::exp(-x)); }

/// Probability that the rate of changes is below one half when `changed` blocks changed and
/// `unchanged` blocks did not. The prior is uniform.
double probability_below_half(double changed, double unchanged) {
  const Eigen::Array<double, 1, 1> a(changed + 1.0);
  const Eigen::Array<double, 1, 1> b(unchanged + 1.0);
  const Eigen::Array<double, 1, 1> half(0.5);
  constexpr double kLeast = 1e-300;
  return std::max(kLeast, Eigen::betainc(a, b, half)(0));
}

/// Share of the poses `shifted`, and of the one that block `i` favours, that do not match what is
/// in the block as the favoured pose does.
double distinctiveness(std::size_t i, double middle_llr, const EvidenceScore& rival,
                       std::span<const EvidenceScore* const> shifted) {
  const auto copies = std::ranges::count_if(shifted, [&](const EvidenceScore* one) {
    return one != &rival && static_cast<double>(one->block_llr[i]) > middle_llr;
  });
  return 1.0 - static_cast<double>(copies) / (1.0 + static_cast<double>(shifted.size()));
}

}  // namespace

double rival_log_odds(const EvidenceScore& best, const EvidenceScore& rival,
                      std::span<const EvidenceScore* const> shifted) {
  double favouring_best = 0.0;
  double favouring_rival = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < std::min(best.block_llr.size(), rival.block_llr.size()); ++i) {
    const auto best_llr = static_cast<double>(best.block_llr[i]);
    const auto rival_llr = static_cast<double>(rival.block_llr[i]);
    const double difference = std::abs(best_llr - rival_llr);
    const double weight = distinctiveness(i, 0.5 * (best_llr + rival_llr), rival, shifted);
    (best_llr > rival_llr ? favouring_best : favouring_rival) += weight * difference;
    squares += weight * difference * difference;
  }
  if (squares <= 0.0) return 0.0;
  // Sums become effective numbers: n = (sum w d)^2 / sum w d^2, shared as the sums are.
  const double scale = (favouring_best + favouring_rival) / squares;
  const double for_best = scale * favouring_best;
  const double for_rival = scale * favouring_rival;
  return std::log(probability_below_half(for_rival, for_best)) -
         std::log(probability_below_half(for_best, for_rival));
}

double chance_significance(const EvidenceScore& best, double free_area_m2) {
  const double share = std::clamp(explained_share(best), 1e-6, 1.0 - 1e-6);
  const double entropy = share * std::log(share / kChanceShare) +
                         (1.0 - share) * std::log((1.0 - share) / (1.0 - kChanceShare));
  const double sign = share > kChanceShare ? 1.0 : -1.0;
  // Hits in unknown space neither explain nor contradict.
  const double hits = best.independent_hits * (1.0 - best.unmapped);
  return sign * hits * entropy - std::log(std::max(1.0, kPosesPerSquareMetre * free_area_m2));
}

AcceptanceTerms weigh(const EvidenceScore& best, double margin, std::span<const double> log_odds,
                      double free_area_m2) {
  AcceptanceTerms terms;
  if (best.ends == 0 || margin <= 0.0) return terms;
  terms.explained_share = explained_share(best);
  terms.independent_hits = best.independent_hits;
  terms.significance =
      std::clamp(chance_significance(best, free_area_m2), kLeastSignificance, kMostSignificance);
  terms.margin_per_hit = margin / best.ends;
  double odds_of_rivals = 0.0;
  for (const double one : log_odds) odds_of_rivals += std::exp(-one);
  terms.rival_evidence =
      std::clamp(-std::log(odds_of_rivals), kLeastRivalEvidence, kMostRivalEvidence);
  terms.unknown_share = best.unmapped;
  terms.probability_explained = logistic(kExplainedOffset + kExplainedSlope * terms.significance);
  terms.probability_best = logistic(terms.rival_evidence);
  terms.probability_correct = terms.probability_explained * terms.probability_best;
  return terms;
}

}  // namespace cornerfix
