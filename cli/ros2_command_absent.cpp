#include "cli/command.hpp"

namespace cornerfix::cli {

// Compiled in place of ros2_command.cpp where Cyclone DDS was not found.
void add_ros2_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("ros2", "Localize robots of ROS 2: not built here");
  command->prefix_command();
  command->callback([&exit_code] {
    exit_code = fail({ErrorCode::kUnavailable,
                      "this cornerfix was built without ROS 2; install cyclonedds-dev and "
                      "cyclonedds-tools, then configure with -DCORNERFIX_BUILD_ROS2=ON",
                      ""});
  });
}

}  // namespace cornerfix::cli
