#include "core/src/acceptance/acceptance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cornerfix {
namespace {

// The share of hits that the best of some poses near a random one explains.
constexpr double kChanceShare = 0.2;
// Distinct poses per square metre of free space: 0.5 m apart, 24 headings.
constexpr double kPosesPerSquareMetre = 100.0;

// Largest values that the calibration data cover.
constexpr double kMostSignificance = 15.0;
constexpr double kLeastSignificance = -25.0;
constexpr double kMostMarginPerHit = 0.75;
// Evidence against rivals without any rival, and with many as good as the best [nat].
constexpr double kMostRivalEvidence = 8.0;
constexpr double kLeastRivalEvidence = -3.0;

// Coefficients of the three logistic models. By theory, the slopes of the first and of the last are
// 1, because their terms are logarithms of odds. The data prefer 0.8 for the first.
constexpr double kExplainedOffset = 7.31;
constexpr double kExplainedSlope = 0.8;
constexpr double kMarginOffset = -1.47;
constexpr double kMarginSlope = 43.0;
constexpr double kKnownSlope = 2.64;
constexpr double kRivalOffset = 2.18;

double logistic(double x) { return 1.0 / (1.0 + std::exp(-x)); }
double log_odds(double probability) { return std::log(probability / (1.0 - probability)); }

double explained_logit(double significance) {
  return kExplainedOffset + kExplainedSlope * significance;
}

double margin_logit(double margin_per_hit, double unknown_share) {
  return kMarginOffset + kMarginSlope * margin_per_hit +
         kKnownSlope * std::log(1.02 - unknown_share);
}

}  // namespace

double margin_z(const EvidenceScore& best, const EvidenceScore& rival) {
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < std::min(best.block_llr.size(), rival.block_llr.size()); ++i) {
    const double difference =
        static_cast<double>(best.block_llr[i]) - static_cast<double>(rival.block_llr[i]);
    sum += difference;
    squares += difference * difference;
  }
  return squares > 0.0 ? sum / std::sqrt(squares) : 0.0;
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

AcceptanceTerms weigh(const EvidenceScore& best, double margin, std::span<const double> rival_z,
                      double free_area_m2) {
  AcceptanceTerms terms;
  if (best.ends == 0 || margin <= 0.0) return terms;
  terms.explained_share = explained_share(best);
  terms.independent_hits = best.independent_hits;
  terms.significance =
      std::clamp(chance_significance(best, free_area_m2), kLeastSignificance, kMostSignificance);
  terms.margin_per_hit = std::min(margin / best.ends, kMostMarginPerHit);
  double rivals = 0.0;
  for (const double z : rival_z) rivals += std::exp(-0.5 * z * std::max(0.0, z));
  terms.rival_evidence = std::clamp(-std::log(rivals), kLeastRivalEvidence, kMostRivalEvidence);
  terms.unknown_share = best.unmapped;
  terms.probability_explained = logistic(explained_logit(terms.significance));
  terms.probability_best = logistic(margin_logit(terms.margin_per_hit, terms.unknown_share));
  if (!rival_z.empty()) terms.probability_best *= logistic(kRivalOffset + terms.rival_evidence);
  terms.probability_correct = terms.probability_explained * terms.probability_best;
  return terms;
}

double margin_for(const EvidenceScore& best, double free_area_m2, double probability) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (best.ends == 0) return kNever;
  const double explained = logistic(explained_logit(
      std::clamp(chance_significance(best, free_area_m2), kLeastSignificance, kMostSignificance)));
  if (explained <= probability) return kNever;
  const double per_hit =
      (log_odds(probability / explained) - margin_logit(0.0, best.unmapped)) / kMarginSlope;
  return std::max(0.0, per_hit) * best.ends;
}

}  // namespace cornerfix
