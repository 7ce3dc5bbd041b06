#include "server/batch_digest.hpp"

#include <cstddef>
#include <vector>

namespace cornerfix::server {
namespace {

/// FNV-1a, 64 bits.
class Hash {
 public:
  template <typename T>
  void add(const T& value) {
    add_bytes(std::as_bytes(std::span(&value, 1)));
  }
  void add_bytes(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) {
      hash_ = (hash_ ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3U;
    }
  }
  void add(const Pose2& pose) {
    for (const double value : {pose.x, pose.y, pose.yaw}) add(value);
  }
  [[nodiscard]] std::uint64_t value() const { return hash_ == 0 ? 1 : hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

void add(Hash& hash, const RobotScan& robot_scan) {
  const LaserScan& scan = robot_scan.scan;
  for (const double value : {scan.stamp, scan.angle_min, scan.angle_increment}) hash.add(value);
  hash.add(scan.ranges.size());
  hash.add_bytes(std::as_bytes(std::span(scan.ranges)));
  hash.add(robot_scan.T_base_link_laser);
  hash.add(robot_scan.T_odom_base_link.has_value());
  if (robot_scan.T_odom_base_link) hash.add(*robot_scan.T_odom_base_link);
}

}  // namespace

std::uint64_t digest_of(std::span<const RobotScan> scans) {
  Hash hash;
  for (const RobotScan& scan : scans) add(hash, scan);
  return hash.value();
}

}  // namespace cornerfix::server
