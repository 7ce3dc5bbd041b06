/// \file  Corners that OpenCV finds in the picture of a scan: the door to its feature detectors.
#pragma once

#include <vector>

#include <cornerfix/corners.hpp>
#include <cornerfix/laser_scan.hpp>

namespace cornerfix::bench {

/// A picture of the returns, a pixel each where it lies, as the paper has it.
struct ScanPictureParams {
  double resolution_m = 0.02;  ///< [m/pixel]; > 0.
};

/// Harris corners (cv::cornerHarris) over a hundredth of the best score, in `laser`.
[[nodiscard]] std::vector<Feature> extract_harris_corners(const LaserScan& scan,
                                                          const ScanPictureParams& params);

/// Key points of cv::ORB with its defaults, in `laser`.
[[nodiscard]] std::vector<Feature> extract_orb_corners(const LaserScan& scan,
                                                       const ScanPictureParams& params);

}  // namespace cornerfix::bench
