#include "bench/external/image_corners.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace cornerfix::bench {
namespace {

constexpr int kMargin = 32;  // [pixels] that detectors leave out at the border
constexpr double kHarrisShare = 0.01;

/// The returns drawn in white, and where that lies.
struct ScanPicture {
  cv::Mat image;
  Point2 origin_laser = Point2::Zero();  ///< Centre of pixel (0, 0).
  double resolution = 0.0;

  [[nodiscard]] Point2 at(double column, double row) const {
    return origin_laser + resolution * Point2(column, row);
  }
};

ScanPicture draw(const LaserScan& scan, const ScanPictureParams& params) {
  const std::vector<Point2> points = returns_as_points(scan);
  Point2 low = Point2::Zero();
  Point2 high = Point2::Zero();
  for (const Point2& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  ScanPicture picture;
  picture.resolution = params.resolution_m;
  picture.origin_laser = low - Point2::Constant(kMargin * params.resolution_m);
  const Point2 size = (high - low) / params.resolution_m;
  picture.image = cv::Mat::zeros(static_cast<int>(size.y()) + 2 * kMargin + 1,
                                 static_cast<int>(size.x()) + 2 * kMargin + 1, CV_8UC1);
  for (const Point2& point : points) {
    const Point2 pixel = (point - picture.origin_laser) / params.resolution_m;
    picture.image.at<std::uint8_t>(static_cast<int>(std::lround(pixel.y())),
                                   static_cast<int>(std::lround(pixel.x()))) = 255;
  }
  return picture;
}

}  // namespace

std::vector<Feature> extract_harris_corners(const LaserScan& scan,
                                            const ScanPictureParams& params) {
  const ScanPicture picture = draw(scan, params);
  cv::Mat blurred;
  cv::GaussianBlur(picture.image, blurred, {5, 5}, 0.0);
  cv::Mat response;
  cv::cornerHarris(blurred, response, 5, 3, 0.04);
  double best = 0.0;
  cv::minMaxLoc(response, nullptr, &best);
  std::vector<Feature> corners;
  for (int row = 0; row < response.rows; ++row) {
    for (int column = 0; column < response.cols; ++column) {
      const auto score = static_cast<double>(response.at<float>(row, column));
      if (score > kHarrisShare * best && score > 0.0)
        corners.push_back({.position = picture.at(column, row), .weight = score});
    }
  }
  return corners;
}

std::vector<Feature> extract_orb_corners(const LaserScan& scan, const ScanPictureParams& params) {
  const ScanPicture picture = draw(scan, params);
  std::vector<cv::KeyPoint> points;
  cv::ORB::create()->detect(picture.image, points);
  std::vector<Feature> corners;
  for (const cv::KeyPoint& point : points) {
    corners.push_back(
        {.position = picture.at(static_cast<double>(point.pt.x), static_cast<double>(point.pt.y)),
         .weight = static_cast<double>(point.response)});
  }
  return corners;
}

}  // namespace cornerfix::bench
