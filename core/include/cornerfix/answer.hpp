/// \file  What a localizer answers: status, reason, pose and the terms of the decision.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/pose2.hpp>

namespace cornerfix {

class LocalizationMap;
using LocalizationMapPtr = std::shared_ptr<const LocalizationMap>;

enum class Status {
  kCollecting,  ///< Not enough seen yet; `reason` says what is missing.
  kAmbiguous,   ///< More than one place fits; they are in `hypotheses`, best first.
  kLocalized,   ///< `pose` is the pose at the last scan and may be trusted.
  /// It was localized and the scans no longer fit; the search is on again. Also for a single scan
  /// that fits neither the local map nor the map: the pose returns with the same epoch.
  kLost,
};

/// What is missing while collecting or lost. The wire names are in to_string().
enum class Reason {
  kNone,
  kNoReturns,                 ///< The scans hold no usable return.
  kFewFeatures,               ///< Too few corners seen to look for the place.
  kNoMotion,                  ///< Standing still adds nothing new: drive on.
  kNoMatch,                   ///< No place in the maps fits what was seen.
  kFewEvidence,               ///< A place fits, but too little was seen to be sure.
  kContradicted,              ///< The best place is contradicted by what was seen.
  kOdometryContradictsScans,  ///< As kContradicted, and odometry is ignored.
  kSearching,                 ///< The search of the maps continues at the next scan.
  kPriorContradicted,         ///< No pose in the start region fits what was seen.
  kMirroredScans,             ///< What was seen fits only in a mirror: the lidar hangs upside down.
};
/// States of localizers are stored with reasons: new ones come last.
inline constexpr Reason kLastReason = Reason::kMirroredScans;

/// How far the answer relied on the robot's odometry.
enum class OdometryUse {
  kNone,          ///< The scans came without odometry.
  kUsed,          ///< It agrees with scan matching.
  kWeightedDown,  ///< Its errors are larger than those of usual wheel odometry.
  kIgnored,       ///< It contradicts scan matching.
};

/// Why a pose that was `localized` was withdrawn at this scan.
enum class Withdrawal {
  kNone,
  kScansLost,     ///< The scans no longer continue the local map: the robot was carried.
  kContradicted,  ///< The scans contradict the map at this pose.
  kRival,         ///< Another pose explains the scans better.
};

[[nodiscard]] std::string_view to_string(OdometryUse use);
[[nodiscard]] std::string_view to_string(Withdrawal withdrawal);
[[nodiscard]] std::string_view to_string(Status status);
[[nodiscard]] std::string_view to_string(Reason reason);

inline constexpr std::size_t kEndClasses = 14;  ///< Classes of hits, named by hits_by_class().
inline constexpr std::size_t kPassClasses = 4;  ///< Of misses, named by misses_by_class().

/// The log-likelihood ratio of a pose, by the class of each hit and miss. A hit is a hit, a
/// miss is a place that beams passed. Both are thinned to cells.
struct EvidenceScore {
  std::array<int, kEndClasses> end_counts{};    ///< Hits by class.
  std::array<int, kPassClasses> pass_counts{};  ///< Passed places by class.
  double fit = 0.0;                ///< Log-likelihood ratio that ranks poses in the search [nat].
  double log_likelihood = 0.0;     ///< Log-likelihood ratio that the decision compares [nat].
  int ends = 0;                    ///< Hits judged.
  std::vector<float> block_llr{};  ///< log_likelihood by block [nat].
  /// Effective number of squares that the hits spread over: (sum n)^2 / sum n^2 of their counts n.
  double independent_hits = 0.0;
  // Shares of the ends:
  double matched = 0.0;       ///< Within 0.15 m of a wall.
  double contradicted = 0.0;  ///< In known-free space, more than 0.3 m from a wall.
  double unmapped = 0.0;      ///< In unknown space.
};

/// Hits or misses of one class. The class says what the map holds where they fall.
struct EvidenceClass {
  std::string name;
  int count = 0;
  double decision_llr = 0.0;  ///< Their part of EvidenceScore::log_likelihood [nat].
};

/// The classes with a count, in a fixed order.
[[nodiscard]] std::vector<EvidenceClass> hits_by_class(const EvidenceScore& score);
[[nodiscard]] std::vector<EvidenceClass> misses_by_class(const EvidenceScore& score);

/// What the decision to accept a pose weighs.
struct AcceptanceTerms {
  // The pose by itself:
  double explained_share = 0.0;  ///< Of the hits, the share within 0.15 m of a wall.
  double significance = 0.0;     ///< Against the best of all poses by chance [nat].
  // The pose and its rivals:
  double margin_per_hit = 0.0;  ///< Log-likelihood ratio to the strongest rival [nat].
  /// Logarithm of the odds that the pose is correct and not one of the rivals, by the squares in
  /// which they differ [nat], within limits.
  double rival_evidence = 0.0;
  double unknown_share = 0.0;  ///< Of the hits, in space unknown to the map.
  double independent_hits = 0.0;

  double probability_explained = 0.0;  ///< That the pose is not one that fits by chance.
  double probability_best = 0.0;       ///< That no other pose is the correct one.
  double probability_correct = 0.0;    ///< Their product.
};

/// A ranked candidate pose. `T_map_base_link` is the pose at the last scan if the candidate is
/// true.
struct RankedHypothesis {
  LocalizationMapPtr map;
  Pose2 T_map_base_link;
  int votes = 0;           ///< Descriptor votes (eq. 15) behind it.
  int inliers = 0;         ///< Correspondences that RANSAC kept (eq. 16).
  double score = 0.0;      ///< Share of the local points that the map explains, in [0, 1].
  EvidenceScore evidence;  ///< Of the scans in the submap.
};

struct LocalizedPose {
  LocalizationMapPtr map;
  Pose2 T_map_base_link;
  std::array<double, 9> covariance{};  ///< Row-major x y yaw [m, rad].
  /// Rises by one at each acceptance, when the pose is not continuous with those before. Survives
  /// reset().
  std::uint64_t epoch = 0;
  bool confirmed = false;  ///< Evidence seen after the acceptance, on new ground, agrees.
};

/// Milliseconds spent a step, by the clock handed to the localizer; zeros without one.
struct StepTimes {
  double odometry_ms = 0.0;
  double extract_ms = 0.0;
  double match_ms = 0.0;
  double verify_ms = 0.0;
  double track_ms = 0.0;
  double total_ms = 0.0;
};

struct Answer {
  Status status = Status::kCollecting;
  std::optional<LocalizedPose> pose;  ///< Only when localized. Never stale, never made up.
  double confidence = 0.0;            ///< Probability that the best hypothesis is right, in [0, 1].
  std::vector<RankedHypothesis> hypotheses;  ///< Best first.
  Reason reason = Reason::kNone;
  AcceptanceTerms terms;  ///< What the decision on the best hypothesis weighed last.
  OdometryUse odometry = OdometryUse::kNone;
  Withdrawal withdrawal = Withdrawal::kNone;  ///< Of a pose, at this scan.
  /// The probability is conditional on the start region: only poses there were compared.
  bool is_given_region = false;
  bool searched = false;  ///< Whether this scan made it look at all places of all maps.
  /// Maps that were considered: searched, or ranked and found worse than those searched.
  std::size_t searched_maps = 0;
  int local_scans = 0;       ///< Scans in the submap.
  int local_features = 0;    ///< Features of the submap.
  Pose2 T_submap_base_link;  ///< Pose at the last scan in the submap.
  StepTimes times;
};

}  // namespace cornerfix
