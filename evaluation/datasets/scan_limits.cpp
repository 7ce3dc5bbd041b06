#include "evaluation/datasets/scan_limits.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace cornerfix::evaluation {

namespace {

// As the HTTP API takes them.
constexpr double kLatestStamp = 1e12;      // [s]
constexpr double kFarthestPosition = 1e8;  // [m]
constexpr double kMillisecondStamps = 1e15;

Error beyond(const char* field, const std::string& message) {
  return {ErrorCode::kMalformed, message, field};
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

std::optional<Error> find_far_pose(const char* field, const std::optional<Pose2>& pose) {
  if (!pose || std::max(std::abs(pose->x), std::abs(pose->y)) <= kFarthestPosition) {
    return std::nullopt;
  }
  return beyond(field, "expected x and y within 1e8 m, not " + number_text(pose->x) + " and " +
                           number_text(pose->y));
}

}  // namespace

std::optional<Error> find_value_beyond_limits(const LogScan& scan) {
  const double stamp = std::abs(scan.scan.stamp);
  if (!(stamp <= kLatestStamp)) {
    const char* const unit = stamp < kMillisecondStamps ? "milliseconds" : "micro- or nanoseconds";
    return beyond("stamp", "expected seconds from -1e12 to 1e12, not " +
                               number_text(scan.scan.stamp) + "; are these " + unit + "?");
  }
  if (auto error = find_far_pose("odom", scan.T_odom_laser)) return error;
  return find_far_pose("pose", scan.T_map_laser);
}

}  // namespace cornerfix::evaluation
