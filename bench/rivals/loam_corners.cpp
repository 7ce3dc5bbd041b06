#include "bench/rivals/loam_corners.hpp"

namespace cornerfix::bench {

std::vector<Feature> extract_loam_corners(const LaserScan& scan, const VfpParams& params) {
  std::vector<Feature> corners;
  for (const ScanSegment& segment : cut_into_segments(scan, params.segments)) {
    const std::vector<double> scores = smoothness_scores(segment.points, params.window);
    for (std::size_t i = 0; i < scores.size(); ++i) {
      if (scores[i] > params.min_score)
        corners.push_back({.position = segment.points[i].position, .weight = scores[i]});
    }
  }
  return corners;
}

}  // namespace cornerfix::bench
