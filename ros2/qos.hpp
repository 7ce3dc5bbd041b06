/// \file  The QoS profiles of rclcpp and tf2_ros.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>

namespace cornerfix::ros2 {

struct QosProfile {
  dds_reliability_kind_t reliability;
  dds_durability_kind_t durability;
  std::int32_t depth;  ///< Keep last.
};

/// rclcpp::SensorDataQoS. A best-effort reader matches every publisher, a reliable one as well.
inline constexpr QosProfile kSensorData{DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE, 5};
/// As robot_localization subscribes odometry: it is faster than scans.
inline constexpr QosProfile kOdometry{DDS_RELIABILITY_BEST_EFFORT, DDS_DURABILITY_VOLATILE, 50};
/// rclcpp::SystemDefaultsQoS, with which rviz publishes /initialpose and amcl subscribes it.
inline constexpr QosProfile kDefault{DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_VOLATILE, 10};
/// tf2_ros::DynamicListenerQoS and DynamicBroadcasterQoS.
inline constexpr QosProfile kTf{DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_VOLATILE, 100};
/// tf2_ros::StaticListenerQoS: who comes late gets what was published before.
inline constexpr QosProfile kTfStatic{DDS_RELIABILITY_RELIABLE, DDS_DURABILITY_TRANSIENT_LOCAL,
                                      100};

using QosPtr = std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)>;

/// Plain CDR (XCDR1), as ROS 2 writes it.
[[nodiscard]] inline QosPtr make_qos(const QosProfile& profile) {
  constexpr dds_duration_t kMaxBlocking = DDS_MSECS(100);
  constexpr dds_data_representation_id_t kPlainCdr = DDS_DATA_REPRESENTATION_XCDR1;
  QosPtr qos(dds_create_qos(), dds_delete_qos);
  dds_qset_reliability(qos.get(), profile.reliability, kMaxBlocking);
  dds_qset_durability(qos.get(), profile.durability);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, profile.depth);
  dds_qset_data_representation(qos.get(), 1, &kPlainCdr);
  return qos;
}

}  // namespace cornerfix::ros2
