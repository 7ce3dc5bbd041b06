/// \file  Judges poses by the hits of a robot and the sketch of a map.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <cornerfix/map_sketch.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

/// Poses are those of base_link in `grid` of a sketch.
class HitJudge {
 public:
  /// \param hits  In base_link; some of them are used.
  explicit HitJudge(std::span<const Point2> hits);

  [[nodiscard]] bool empty() const { return hits_.empty(); }

  /// Mean weight of all hits at a pose [nat]; nothing when base_link is not in known space, or the
  /// first hits show that the pose is hopeless.
  [[nodiscard]] std::optional<double> mean_at(const MapSketch& sketch, const Pose2& pose) const;

  /// The best pose near one, by small steps.
  [[nodiscard]] std::pair<double, Pose2> refined(const MapSketch& sketch, double mean,
                                                 Pose2 pose) const;

 private:
  std::vector<Point2> hits_;  ///< In an order whose beginning is spread over all.
};

}  // namespace cornerfix
