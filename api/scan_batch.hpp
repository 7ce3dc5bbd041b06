/// \file  `lidar` and `scans` of a request: the contract's form and sensor_msgs/LaserScan.
#pragma once

#include <optional>
#include <vector>

#include "api/document_builder.hpp"
#include "api/json_field.hpp"
#include "api/requests.hpp"

namespace cornerfix::api {

/// A scan with the poses that came with it.
struct BatchScan {
  LaserScan scan;
  std::optional<Pose2> T_odom_base_link;
  std::optional<Pose2> T_map_base_link;
  double time_increment = 0.0;  ///< From beam to beam [s]; 0 when it was taken at once.
};

struct ScanBatch {
  std::optional<Lidar> lidar;  ///< In use; nothing when each scan brings its own.
  std::vector<BatchScan> scans;

  [[nodiscard]] Pose2 T_base_link_laser() const {
    return lidar ? lidar->T_base_link_laser : Pose2{};
  }
};

enum class StampOrder { kAny, kIncreasing };
enum class MapPose { kRefused, kTaken };

/// Nothing when it is wrong; the field's errors then have the reason.
[[nodiscard]] std::optional<Lidar> read_lidar(const JsonField& field);

/// Takes the ranges out of `document`. `lidar` is used where the body has none. What is wrong is in
/// document.errors.
[[nodiscard]] ScanBatch read_scan_batch(Document& document, const std::optional<Lidar>& lidar,
                                        StampOrder order, MapPose map_pose);

}  // namespace cornerfix::api
