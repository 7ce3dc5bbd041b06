#include "core/src/scan/wall_distance.hpp"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace cornerfix {
namespace {

// OpenCV's transform squares columns in single precision: from the 4096th on it loses cells. So it
// is done for a part of the columns at a time, each with so many neighbours that none is missed.
constexpr int kColumns = 2048;
constexpr int kOverlap = 256;
static_assert(kColumns + 2 * kOverlap < 4096);

}  // namespace

std::vector<float> distances_to_walls(const OccupancyGrid& grid) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<float> distances(grid.cells.size(), kInfinity);
  if (grid.cells.empty() || std::ranges::find(grid.cells, Cell::kOccupied) == grid.cells.end())
    return distances;
  cv::Mat clear(grid.height, grid.width, CV_8U);
  std::ranges::transform(grid.cells, clear.begin<std::uint8_t>(),
                         [](Cell cell) { return cell == Cell::kOccupied ? 0 : 1; });
  cv::Mat target(grid.height, grid.width, CV_32F, distances.data());
  const bool is_whole = grid.width <= kColumns + 2 * kOverlap;
  const int columns = is_whole ? grid.width : kColumns;
  for (int first = 0; first < grid.width; first += columns) {
    const cv::Range inner(first, std::min(grid.width, first + columns));
    const cv::Range outer(std::max(0, inner.start - kOverlap),
                          std::min(grid.width, inner.end + kOverlap));
    const cv::Mat part = clear.colRange(outer);
    cv::Mat here = target.colRange(inner);
    if (cv::countNonZero(part) == static_cast<int>(part.total())) {
      here.setTo(static_cast<float>(kOverlap));  // the transform has nothing to measure from
      continue;
    }
    cv::Mat found;
    cv::distanceTransform(part, found, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
    const cv::Mat wanted = found.colRange(inner - outer.start);
    if (is_whole)
      wanted.copyTo(here);
    else
      cv::min(wanted, static_cast<double>(kOverlap), here);
  }
  return distances;
}

}  // namespace cornerfix
