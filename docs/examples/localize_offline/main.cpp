// Makes a map from scans at known poses, then localizes a robot in it that does not know where it
// is. The scans are cast in a ROS occupancy map here; on a robot they come from its lidar.
#include <cornerfix/localizer.hpp>
#include <cornerfix/map_image.hpp>
#include <cornerfix/mapper.hpp>
#include <cornerfix/occupancy_grid.hpp>

#include <cstdio>
#include <memory>
#include <numbers>

using namespace cornerfix;

namespace {

constexpr std::size_t kBeams = 720;
const LaserScan kLidar{.angle_min = -std::numbers::pi,
                       .angle_increment = 2.0 * std::numbers::pi / kBeams,
                       .range_min = 0.1,
                       .range_max = 20.0,
                       .ranges = {}};

LaserScan look(const RayCaster& building, const Pose2& T_map_laser, double stamp) {
  LaserScan scan = building.scan(kLidar, kBeams, T_map_laser);
  scan.stamp = stamp;
  return scan;
}

/// A corridor of the Willow Garage building, mapped by a robot that knows its poses.
LocalizationMapPtr make_map(const RayCaster& building) {
  Mapper mapper;
  for (double x = 14.0; x <= 33.0; x += 0.25) {
    const PosedScan scan{.scan = look(building, {x, 17.6, 0.0}, x),
                         .T_base_link_laser = {},
                         .T_map_base_link = {x, 17.6, 0.0}};
    if (mapper.is_key_frame(scan)) mapper.add(scan);
  }
  return std::make_shared<LocalizationMap>("willow", 1, mapper.build());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: localize_offline MAP.yaml\n"), 2;
  const Result<OccupancyGrid> floor = read_map_files(argv[1]);
  if (!floor) return std::fprintf(stderr, "%s\n", floor.error().message.c_str()), 1;
  const RayCaster building(*floor);

  Localizer localizer({make_map(building)}, LocalizerParams{});
  for (double way = 0.0; way < 10.0; way += 0.1) {
    // The way back, a little aside. The localizer gets the odometry, never the true pose.
    const Pose2 truth{28.0 - way, 17.4, std::numbers::pi};
    const Answer answer = localizer.process({.scan = look(building, truth, way),
                                             .T_base_link_laser = {},
                                             .T_odom_base_link = Pose2{way, 0.0, 0.0}});
    if (!answer.pose) continue;
    const Pose2& pose = answer.pose->T_map_base_link;
    std::printf(
        "localized after %.1f m at x %.2f m, y %.2f m, yaw %.3f rad; truly x %.2f m, y %.2f m\n",
        way, pose.x, pose.y, pose.yaw, truth.x, truth.y);
    return distance(pose, truth) < 0.3 ? 0 : 1;
  }
  std::printf("not localized within 10 m\n");
  return 1;
}
