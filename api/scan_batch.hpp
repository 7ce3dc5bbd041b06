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
  Pose2 T_base_link_laser;
};

struct ScanBatch {
  std::optional<Lidar> lidar;  ///< In use; nothing when each scan brings its own.
  std::vector<BatchScan> scans;
};

enum class StampOrder { kAny, kIncreasing };
enum class MapPose { kRefused, kTaken };

/// Nothing when it is wrong; the field's errors then have the reason.
[[nodiscard]] std::optional<Lidar> read_lidar(const JsonField& field);

/// Adds an error for what can be read but is no lidar: a mount in millimetres or degrees, a scan of
/// more than ten seconds. Apart from read_lidar(), which also reads lidars that are stored already.
void check_lidar(const JsonField& field);
/// The same for `lidar` or `lidars` of a session.
void check_lidars(const JsonField& session);

/// `lidar` or `lidars` of a session, or none.
[[nodiscard]] Lidars read_lidars(const JsonField& session);

/// Takes the ranges out of `document`. `lidars` are used where the body has none; with several,
/// each scan names its own, and scans are put in the order of their stamps. Scans are levelled and
/// straightened. What is wrong is in document.errors.
[[nodiscard]] ScanBatch read_scan_batch(Document& document, const Lidars& lidars, StampOrder order,
                                        MapPose map_pose);

}  // namespace cornerfix::api
