/// \file  A 2D scan from a 3D point cloud.
#pragma once

#include <Eigen/Geometry>

#include <cornerfix/laser_scan.hpp>

#include "evaluation/datasets/bag/ros_messages.hpp"
#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// The nearest point of each bearing among those within the height band.
/// \param rotation  Of the cloud's frame against the level. The scan's frame is the cloud's turned
///                  about a horizontal axis until it is level; its x axis looks the same way.
/// Bearings are as far apart as the points are, from 0.25 to 2 degrees, all round. There is no
/// limit of range. Without points in the band the scan has no returns.
[[nodiscard]] LaserScan slice(const PointCloudMessage& cloud, const Eigen::Matrix3d& rotation,
                              const HeightBand& band);

}  // namespace cornerfix::evaluation
