/// \file  Robots of ROS 2 as clients of a Cornerfix server.
#pragma once

#include <memory>

#include <cornerfix/result.hpp>

#include "ros2/bridge_options.hpp"

namespace cornerfix::ros2 {

/// All robots in one DDS participant, each with threads of its own. They are switched off when it
/// is destroyed.
class Bridge {
 public:
  /// An error when robots share a name or topics, when the server refuses the token or a map, or
  /// when DDS cannot be joined. A server that cannot be reached is waited for.
  ///
  /// \param log  Called by several threads, one at a time.
  [[nodiscard]] static Result<std::unique_ptr<Bridge>> start(BridgeOptions options, const Log& log);
  ~Bridge();
  Bridge(const Bridge&) = delete;
  Bridge& operator=(const Bridge&) = delete;

 private:
  struct Parts;
  explicit Bridge(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace cornerfix::ros2
