/// \file  What a bridge between ROS 2 and a Cornerfix server is to do.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <cornerfix/localizer_params.hpp>

#include "ros2/topic_names.hpp"

namespace cornerfix::ros2 {

/// Writes a line for people.
using Log = std::function<void(const std::string&)>;

struct ServerAddress {
  std::string url;    ///< May end in a path that all calls begin with.
  std::string token;  ///< Bearer token; empty for none.
};

enum class PublishWhen {
  kLocalized,
  kConfirmed,  ///< Localized, and scans of 3 m of new ground agree.
};

struct RobotName {
  std::string name;  ///< On the server.
  std::string ns;    ///< Namespace of its topics; empty for none.
};

struct BridgeOptions {
  ServerAddress server;
  std::vector<RobotName> robots;    ///< One or more.
  std::vector<std::string> maps;    ///< Where robots may be; empty for all maps of the server.
  std::optional<StartRegion> near;  ///< Where robots are switched on, in each of the maps.

  std::uint32_t domain = 0;
  bool is_local_only = false;  ///< Loopback only, as with ROS_LOCALHOST_ONLY=1.
  Remappings remappings;
  std::vector<std::string> scan_topics = {"scan"};  ///< One per lidar of a robot.

  std::string map_frame = "map";
  std::string base_frame = "base_link";  ///< "robot1/base_link" is called so, too.
  double max_rate_hz = 10.0;             ///< Scans that are posted per second of stamps.
  PublishWhen when = PublishWhen::kLocalized;
  bool publishes_tf = false;  ///< The transform from `map_frame` to odom.
};

}  // namespace cornerfix::ros2
