/// \file  The front door: maps and a robot's scans in, its status and pose out (eq. 17).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <cornerfix/acceptance.hpp>
#include <cornerfix/laser_scan.hpp>
#include <cornerfix/localization_map.hpp>
#include <cornerfix/localizer_params.hpp>
#include <cornerfix/submap.hpp>

namespace cornerfix {

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
  kSearching,  ///< The search of the maps continues at the next scan.
};

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

/// A ranked candidate. `T_map_base_link` is the pose at the last scan if the candidate is true.
struct RankedHypothesis {
  LocalizationMapPtr map;
  Pose2 T_map_base_link;
  int votes = 0;           ///< Descriptor votes (eq. 15) behind it.
  int inliers = 0;         ///< Correspondences that RANSAC kept (eq. 16).
  double score = 0.0;      ///< Share of the local points that the map explains, in [0, 1].
  EvidenceScore evidence;  ///< What the submap's scans say of it.
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
  bool searched = false;     ///< Whether this scan made it look at all places of all maps.
  int local_scans = 0;       ///< Scans in the submap.
  int local_features = 0;    ///< Features of the submap.
  Pose2 T_submap_base_link;  ///< Pose at the last scan in the submap.
  StepTimes times;
};

/// What a localizer remembers: enough to go on in another process. Hypotheses are not kept; the
/// next scan that joins the submap makes them anew.
struct LocalizerState {
  std::vector<SubmapScan> submap;
  std::uint64_t next_index = 0;      ///< Of the next scan to join the submap.
  std::uint64_t scans = 0;           ///< Processed since the reset; seeds the random draws.
  Pose2 T_submap_base_link;          ///< At the last scan.
  Pose2 last_motion;                 ///< Between the last two scans, for constant velocity,
  double last_interval_s = 0.0;      ///< and the time between them; 0 when not known.
  std::optional<double> last_stamp;  ///< [s]
  std::optional<Pose2> last_T_odom_base_link;
  Status status = Status::kCollecting;
  Reason reason = Reason::kFewFeatures;
  double confidence = 0.0;
  int tracked_map = -1;       ///< Index into the localizer's maps, or -1.
  Pose2 T_map_submap;         ///< Valid while tracked_map >= 0.
  int misfits = 0;            ///< Consecutive scans that did not fit while localized.
  double misfit_way_m = 0.0;  ///< Driven since a scan fitted.
  /// Row-major, of x, y, yaw; all zeros: that of a new fix.
  std::array<double, 9> tracking_covariance{};
  std::optional<double> usual_fit;    ///< Share of a scan's ends that are on walls where mapped.
  std::optional<double> usual_share;  ///< Share of a scan's points that match the submap.
  std::array<double, 6> odometry_sums{};  ///< Of OdometryMonitor.
  std::uint64_t epoch = 0;                ///< Of the last accepted pose.
  bool confirmed = false;                 ///< The tracked pose.
  double distance_since_acceptance_m = 0.0;
  double searched_at_m = 0.0;        ///< The same at the last review of all poses.
  std::uint64_t accepted_index = 0;  ///< Of the first submap scan after the acceptance.
};

/// Localizes one robot. Deterministic: same maps, params and scans give the same answers.
/// Not synchronised; one robot, one thread at a time. Maps are shared and never changed.
class Localizer {
 public:
  using Clock = std::function<double()>;  ///< Milliseconds, monotonic; may be empty.

  /// `maps` are searched together; the order carries no meaning but must be that of a restored
  /// state.
  Localizer(std::vector<LocalizationMapPtr> maps, LocalizerParams params, Clock clock = {});
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// Takes one scan. Stamps must increase from call to call until reset() (asserted).
  [[nodiscard]] Answer process(const RobotScan& scan);

  /// The robot was carried: forgets the pose and the submap.
  void reset();

  /// Newer revisions of the same maps, in the same order; the pose and the submap are kept.
  void replace_maps(std::vector<LocalizationMapPtr> maps);

  [[nodiscard]] LocalizerState state() const;
  void restore(LocalizerState state);

  [[nodiscard]] std::optional<double> last_stamp() const;
  [[nodiscard]] const std::vector<LocalizationMapPtr>& maps() const;
  /// Features of the submap in the frame of base_link at the last scan, for drawing.
  [[nodiscard]] std::vector<Point2> local_features_base_link() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornerfix
