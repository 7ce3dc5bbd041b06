/// \file  The paper's localization as published: corners, descriptors, random matching, RANSAC, ICP
/// - and the first match over the threshold is believed.
///
/// Peng et al. 2023, sections 2-3. What the paper takes for granted, the local map, is the submap
/// of this library.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <cornerfix/corners.hpp>
#include <cornerfix/localization_map.hpp>

#include "bench/rivals/rival.hpp"
#include "bench/rivals/search_rival.hpp"
#include "core/src/local_map/submap.hpp"
#include "core/src/matching/descriptor_matcher.hpp"
#include "core/src/matching/pose_estimator.hpp"

namespace cornerfix::bench {

struct PublishedRmaParams {
  int min_votes = 6;              ///< S_t of algorithm 3; the paper does not give its value.
  SampledMatchParams sampling{};  ///< p and N/N_local of eq. (18).
  PoseEstimatorParams estimator{};
};

/// One robot in one map, whose features must be VFP corners.
class PublishedRma : public Rival {
 public:
  PublishedRma(LocalizationMapPtr map, const PublishedRmaParams& params);

  [[nodiscard]] RivalAnswer process(const RobotScan& scan) override;
  [[nodiscard]] std::size_t bytes() const override { return sizeof(*this); }

 private:
  [[nodiscard]] Pose2 match_submap(const Pose2& motion, std::span<const Point2> ends);
  [[nodiscard]] std::optional<Pose2> match_map() const;

  LocalizationMapPtr map_;
  PublishedRmaParams params_;
  Submap submap_;
  Pose2 T_submap_base_link_;
  std::optional<Pose2> last_T_odom_base_link_;
  std::optional<ScanFollower> follower_;
};

}  // namespace cornerfix::bench
