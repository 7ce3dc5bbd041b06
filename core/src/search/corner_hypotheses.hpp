/// \file  Candidate poses of a robot from the corners that it sees: each alone, and by threes.
///
/// An oriented corner of the map and one of the same kind before the robot give a whole pose. So a
/// map of n corners has only a few thousand of them. They cost a fraction of a search of all poses,
/// and most often the correct pose is among them. A pose without any of the corners seen is not, so
/// a pose is accepted only after PlaceSearch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/localization_map.hpp>
#include <cornerfix/pose2.hpp>

namespace cornerfix {

struct CornerHypothesisParams {
  std::size_t max_corners = 8;      ///< Of those seen, the ones seen most often; >= 1.
  std::size_t max_pairs = 6'000;    ///< Of a corner seen and one of the map; bounds the time; >= 1.
  std::size_t max_triangles = 500;  ///< Looked up in the map's index; bounds the time.
  std::size_t max_places = 4;       ///< >= 1
  double min_mean_weight = 0.0;     ///< Poses where the ends weigh less are none [nat].
  std::uint64_t seed = 1;           ///< Of the order of triangles.
};

/// To about 0.2 m and 3 deg: good enough to be refined.
struct Hypothesis {
  Pose2 T_map_base_link;
  double mean_weight = 0.0;  ///< Optimistic mean weight of the ends about the corner [nat].
};

/// \param corners_base_link  Corners seen, with their directions.
/// \param ends_base_link     Where beams ended.
/// base_link is looked for in known-free space only.
/// \return Distinct places, the one with the highest weight first. O(pairs + triangles).
[[nodiscard]] std::vector<Hypothesis> hypotheses_from_corners(
    const LocalizationMap& map, std::span<const Feature> corners_base_link,
    std::span<const Point2> ends_base_link, const CornerHypothesisParams& params);

}  // namespace cornerfix
