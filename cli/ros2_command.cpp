#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cli/command.hpp"
#include "cli/server_options.hpp"
#include "ros2/bridge.hpp"

namespace cornerfix::cli {

namespace {

using ros2::BridgeOptions;

constexpr std::uint32_t kMaxDomain = 232;  // Ports of higher ones do not exist.

constexpr const char* kLocalized = "localized";
constexpr const char* kConfirmed = "confirmed";

struct Ros2Arguments {
  client::ServerAddress server;
  std::string when = kLocalized;
  BridgeOptions bridge;
};

/// As ROS 2 has it, up to Humble and from Iron on.
bool is_local_only() {
  const auto is = [](const char* name, std::string_view value) {
    const char* set = std::getenv(name);
    return set != nullptr && set == value;
  };
  return is("ROS_LOCALHOST_ONLY", "1") || is("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
}

/// NAME or NAME=NAMESPACE.
ros2::RobotName parse_robot(const std::string& text) {
  const std::size_t middle = text.find('=');
  ros2::RobotName robot{text.substr(0, middle), {}};
  if (std::string name = robot.name; !map_name()(name).empty()) {  // Robots are named as maps are.
    throw CLI::ValidationError("--robot", "\"" + robot.name + "\" is no name for a robot, which " +
                                              "matches [A-Za-z0-9][A-Za-z0-9._-]{0,127}");
  }
  if (middle == std::string::npos) return robot;
  robot.ns = text.substr(middle + 1);
  if (!ros2::is_ros_name(robot.ns)) {
    throw CLI::ValidationError("--robot", robot.ns + " is no namespace of ROS");
  }
  return robot;
}

StartRegion parse_near(const std::vector<double>& values) {
  constexpr double kYawTolerance = 0.8;  // [rad], as the server has it.
  StartRegion near{.center = {values[0], values[1]}, .radius_m = values[2]};
  if (values.size() > 3) near.yaw = values[3];
  near.yaw_tolerance_rad = values.size() > 4 ? values[4] : kYawTolerance;
  if (const auto error = validate(near)) {
    throw CLI::ValidationError("--near", error->field + " " + error->message);
  }
  return near;
}

int run_ros2(Ros2Arguments& arguments) {
  BridgeOptions& options = arguments.bridge;
  options.server = {arguments.server.url, arguments.server.token};
  options.is_local_only = is_local_only();
  if (arguments.when == kConfirmed) options.when = ros2::PublishWhen::kConfirmed;
  if (options.robots.empty()) options.robots.push_back({"robot", ""});
  sigset_t stop_signals;
  sigemptyset(&stop_signals);
  for (const int signal : {SIGTERM, SIGINT}) sigaddset(&stop_signals, signal);
  pthread_sigmask(SIG_BLOCK, &stop_signals, nullptr);  // Before any thread is made.
  const auto bridge = ros2::Bridge::start(options, [](const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  });
  if (!bridge) {
    fail(bridge.error());
    return bridge.error().code == ErrorCode::kInvalidArgument ? kWrongUse : kCouldNot;
  }
  int signal = 0;
  sigwait(&stop_signals, &signal);
  return kDone;
}

void add_robot_options(CLI::App& command, Ros2Arguments& arguments) {
  BridgeOptions& options = arguments.bridge;
  command
      .add_option_function<std::vector<std::string>>(
          "--robot",
          [&options](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) options.robots.push_back(parse_robot(text));
          },
          "Name of the robot on the server, and the namespace of its topics; once per robot "
          "(robot, without namespace)")
      ->type_name("NAME[=NAMESPACE]");
  command.add_option("--map", options.maps, "Map to look in; may be repeated (all of the server)")
      ->check(map_name());
  command
      .add_option_function<std::vector<double>>(
          "--near",
          [&options](const std::vector<double>& values) { options.near = parse_near(values); },
          "Where robots are switched on: X, Y and RADIUS in metres in the map; with YAW [rad] also "
          "the heading, to within TOLERANCE (0.8 rad)")
      ->expected(3, 5)
      ->type_name("X Y RADIUS [YAW [TOLERANCE]]");
  command.add_option("--rate", options.max_rate_hz, "Scans to post per second at most")
      ->check(above_zero())
      ->capture_default_str();
  command
      .add_option("--when", arguments.when, "Publish the pose once it is localized, or confirmed")
      ->check(CLI::IsMember({kLocalized, kConfirmed}))
      ->capture_default_str();
  command.add_flag("--tf", options.publishes_tf,
                   "Also publish the transform from map to odom, with every pose");
}

void add_ros_options(CLI::App& command, BridgeOptions& options) {
  command.add_option("--domain", options.domain, "DDS domain")
      ->envname("ROS_DOMAIN_ID")
      ->check(CLI::Range(0U, kMaxDomain))
      ->capture_default_str()
      ->group("ROS 2");
  command
      .add_option_function<std::vector<std::string>>(
          "--remap",
          [&options](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) {
              const auto added = options.remappings.add(text);
              if (!added) throw CLI::ValidationError("--remap", added.error().message);
            }
          },
          "Another name for the topic scan, odom, tf, tf_static, initialpose or diagnostics; one "
          "with a leading / is in no namespace")
      ->type_name("FROM:=TO")
      ->group("ROS 2");
  command
      .add_option_function<std::vector<std::string>>(
          "--scan",
          [&options](const std::vector<std::string>& topics) {
            for (const std::string& topic : topics) {
              if (!ros2::is_ros_name(topic))
                throw CLI::ValidationError("--scan", topic + " is no name of a ROS topic");
            }
            options.scan_topics = topics;
          },
          "Topic of a lidar, for robots with several: once per lidar (scan)")
      ->type_name("TOPIC")
      ->group("ROS 2");
  command.add_option("--base-frame", options.base_frame, "Frame whose pose is published")
      ->capture_default_str()
      ->group("ROS 2");
  command.add_option("--map-frame", options.map_frame, "Frame of published poses")
      ->capture_default_str()
      ->group("ROS 2");
}

}  // namespace

void add_ros2_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<Ros2Arguments>();
  CLI::App* command = app.add_subcommand(
      "ros2", "Localize robots of ROS 2: scans, odometry and tf in, initialpose out");
  command->footer(
      "Speaks ROS 2's wire protocol (DDS); needs no ROS on this machine. Runs until SIGTERM or "
      "Ctrl-C.\n"
      "Subscribes scan, odom, /tf and /tf_static; publishes initialpose when the server has\n"
      "localized the robot, once per epoch, and /diagnostics. ROS_LOCALHOST_ONLY=1 or\n"
      "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST keep to this machine, CYCLONEDDS_URI configures "
      "DDS.\n"
      "docs/tutorials/ros2.md is a walk through.");
  add_robot_options(*command, *arguments);
  add_ros_options(*command, arguments->bridge);
  add_server_options(*command, arguments->server);
  command->callback([arguments, &exit_code] { exit_code = run_ros2(*arguments); });
}

}  // namespace cornerfix::cli
