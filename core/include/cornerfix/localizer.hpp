/// \file  The front door: maps and a robot's scans in, its status and pose out (eq. 17).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/answer.hpp>
#include <cornerfix/laser_scan.hpp>
#include <cornerfix/localization_map.hpp>
#include <cornerfix/localizer_params.hpp>
#include <cornerfix/map_source.hpp>

namespace cornerfix {

/// What a localizer remembers: enough to go on in another process. Hypotheses are not kept; the
/// next scan that joins the submap makes them anew.
struct LocalizerState {
  std::vector<SubmapScanPtr> submap;  ///< None is null.
  std::uint64_t next_index = 0;       ///< Of the next scan to join the submap.
  std::uint64_t scans = 0;            ///< Processed since the reset; seeds the random draws.
  Pose2 T_submap_base_link;           ///< At the last scan.
  Pose2 last_motion;                  ///< Between the last two scans of a laser,
  double last_interval_s = 0.0;       ///< and the time between them; 0 when not known.
  std::optional<double> last_stamp;   ///< [s]
  std::optional<Pose2> last_T_odom_base_link;
  Status status = Status::kCollecting;
  Reason reason = Reason::kFewFeatures;
  double confidence = 0.0;
  int tracked_map = -1;       ///< Index into the localizer's maps, or -1.
  Pose2 T_map_submap;         ///< Valid while tracked_map >= 0.
  int misfits = 0;            ///< Consecutive scans that did not fit while localized.
  double misfit_way_m = 0.0;  ///< Driven since a scan fitted.
  /// Row-major, of x, y, yaw; all zeros: that of a newly accepted pose.
  std::array<double, 9> tracking_covariance{};
  std::optional<double> usual_fit;    ///< Share of a scan's ends that are on walls where mapped.
  std::optional<double> usual_share;  ///< Share of a scan's points that match the submap.
  std::array<double, 6> odometry_sums{};  ///< Of OdometryMonitor.
  std::uint64_t epoch = 0;                ///< Of the last accepted pose.
  bool confirmed = false;                 ///< The tracked pose.
  double distance_since_acceptance_m = 0.0;
  double searched_at_m = 0.0;         ///< The same at the last review of all poses.
  std::uint64_t accepted_index = 0;   ///< Of the first submap scan after the acceptance.
  std::optional<StartRegion> region;  ///< While it restricts the search.
};

/// Localizes one robot. Deterministic: same maps, params and scans give the same answers.
/// Not synchronised; one robot, one thread at a time. Maps are shared and never changed.
class Localizer {
 public:
  using Clock = std::function<double()>;  ///< Milliseconds, monotonic; may be empty.

  /// `maps` are searched together; the order carries no meaning but must be that of a restored
  /// state.
  Localizer(std::vector<LocalizationMapPtr> maps, LocalizerParams params, Clock clock = {});
  /// Maps come from a source when there are too many to hold: those where the robot may be, by what
  /// it saw, are loaded and searched. Each map that may hold the robot and could not be searched
  /// counts as a rival as good as the best pose, so that no pose is accepted beside it.
  /// Once a pose is confirmed, its map alone is held.
  /// \param held  Maps to begin with, in the order of a restored state; others may join and leave.
  Localizer(std::shared_ptr<MapSource> source, std::span<const MapKey> held, LocalizerParams params,
            Clock clock = {});
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// Takes one scan. Stamps must not decrease until reset() (asserted). Those of a laser increase.
  /// Lasers are known by T_base_link_laser. A scan with angles or a mount of NaN has no return.
  [[nodiscard]] Answer process(const RobotScan& scan);

  /// The robot was carried: forgets the pose and the submap. With a region, base_link is there at
  /// the next scan, and only poses there are searched. The restriction moves with the robot. It
  /// ends when scans no longer continue the submap, or when an accepted pose is withdrawn.
  void reset(std::optional<StartRegion> region = std::nullopt);
  /// The region while it restricts the search.
  [[nodiscard]] const std::optional<StartRegion>& region() const;

  /// Newer revisions of maps(), in the same order; the pose and the submap are kept. Without a
  /// source, others may join at the end.
  void replace_maps(std::vector<LocalizationMapPtr> maps);

  [[nodiscard]] LocalizerState state() const;
  void restore(LocalizerState state);

  [[nodiscard]] std::optional<double> last_stamp() const;
  [[nodiscard]] const std::vector<LocalizationMapPtr>& maps() const;
  /// Of maps(), in the same order, for a localizer with a source.
  [[nodiscard]] const std::vector<MapKey>& map_keys() const;
  /// Features of the submap in the frame of base_link at the last scan, for drawing.
  [[nodiscard]] std::vector<Point2> local_features_base_link() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornerfix
