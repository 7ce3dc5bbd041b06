#include "core/src/acceptance/acceptance.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/SpecialFunctions>
#include <vector>

#include "core/src/scan/longest_lines.hpp"

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

/// How two poses differ in a block.
struct BlockDifference {
  double llr = 0.0;     ///< Of the favoured pose less that of the other one [nat].
  double weight = 1.0;  ///< Share of the copies of the place that do not match the block.
  int matching = 0;     ///< Other poses that match the block as the favoured one does.
  bool favours_best = false;
};

std::vector<BlockDifference> differences_of(const EvidenceScore& best, const EvidenceScore& rival,
                                            std::span<const OtherPose> others) {
  const auto shifted = std::ranges::count_if(others, &OtherPose::is_shifted);
  std::vector<BlockDifference> blocks;
  for (std::size_t i = 0; i < std::min(best.block_llr.size(), rival.block_llr.size()); ++i) {
    const auto best_llr = static_cast<double>(best.block_llr[i]);
    const auto rival_llr = static_cast<double>(rival.block_llr[i]);
    BlockDifference block{.llr = std::abs(best_llr - rival_llr),
                          .favours_best = best_llr > rival_llr};
    int copies = 0;
    for (const OtherPose& other : others) {
      if (other.score == &rival || i >= other.score->block_llr.size()) continue;
      if (static_cast<double>(other.score->block_llr[i]) <= 0.5 * (best_llr + rival_llr)) continue;
      ++block.matching;
      if (other.is_shifted) ++copies;
    }
    block.weight -= copies / (1.0 + static_cast<double>(shifted));
    blocks.push_back(block);
  }
  return blocks;
}

/// Effective numbers of blocks that favour each of two poses: n = (sum w d)^2 / sum w d^2, shared
/// as the sums of w d are.
struct BlockNumbers {
  double for_best = 0.0;
  double for_rival = 0.0;
  double scale = 0.0;  ///< Blocks per nat of w d.

  explicit BlockNumbers(std::span<const BlockDifference> blocks) {
    double squares = 0.0;
    for (const BlockDifference& block : blocks) {
      (block.favours_best ? for_best : for_rival) += block.weight * block.llr;
      squares += block.weight * block.llr * block.llr;
    }
    if (squares <= 0.0) return;
    scale = (for_best + for_rival) / squares;
    for_best *= scale;
    for_rival *= scale;
  }
};

/// Log-odds beyond those of a sign test [nat]; >= 0. A sign test takes it that a block that changed
/// matches one of the two poses as probably as the other. Here the probability of a coincidence
/// follows Laplace's rule of succession. Of the `others`, some match the block, and each block that
/// favours the rival is one coincidence that happened.
double coincidence_log_odds(std::span<const BlockDifference> blocks, const BlockNumbers& numbers,
                            std::size_t others) {
  double sum = 0.0;
  for (const BlockDifference& block : blocks) {
    const double coincidence = (block.matching + numbers.for_rival + 1.0) /
                               (static_cast<double>(others) + numbers.for_rival + 2.0);
    const double log_odds = std::max(0.0, -std::log(2.0 * coincidence));
    sum += (block.favours_best ? 1.0 : -1.0) * block.weight * block.llr * log_odds;
  }
  return std::max(0.0, numbers.scale * sum);
}

}  // namespace

double rival_log_odds(const EvidenceScore& best, const EvidenceScore& rival,
                      std::span<const OtherPose> others) {
  const std::vector<BlockDifference> blocks = differences_of(best, rival, others);
  const BlockNumbers numbers(blocks);
  if (numbers.scale <= 0.0) return 0.0;
  const auto others_than_rival = static_cast<std::size_t>(
      std::ranges::count_if(others, [&](const OtherPose& other) { return other.score != &rival; }));
  return std::log(probability_below_half(numbers.for_rival, numbers.for_best)) -
         std::log(probability_below_half(numbers.for_best, numbers.for_rival)) +
         coincidence_log_odds(blocks, numbers, others_than_rival);
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

bool explains_more_than_two_lines(const ClassField& classes, const Evidence& evidence,
                                  const Pose2& T_map_evidence) {
  const std::vector<std::uint8_t> hits = hit_classes(classes, evidence, T_map_evidence);
  std::vector<Point2> explained;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (is_explained(hits[i])) explained.push_back(evidence.ends[i]);
  }
  const std::vector<bool> is_on_lines = are_on_longest_lines(explained, 2);
  EvidenceScore others;
  auto is_on_line = is_on_lines.begin();
  for (const std::uint8_t end_class : hits) {
    if (is_explained(end_class) && *is_on_line++) continue;
    ++others.end_counts[end_class];
    ++others.ends;
  }
  return explained_share(others) > kChanceShare;
}

}  // namespace cornerfix
