/// \file  Which topic and type the numbers of a bag's channels stand for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "cli/bag/ros_messages.hpp"
#include "cli/bag/wire_reader.hpp"

namespace cornerfix::cli {

/// What all messages of a channel share. ROS 1 calls it a connection.
struct Channel {
  std::string topic;
  MessageKind kind = MessageKind::kLaserScan;
  WireFormat format = WireFormat::kRos1;
};

/// Remembers the channels of a kind of use here only.
class ChannelTable {
 public:
  void add(std::uint32_t id, std::string_view topic, std::string_view type, WireFormat format) {
    if (const auto kind = message_kind(type)) channels_[id] = {std::string(topic), *kind, format};
  }

  [[nodiscard]] const Channel* find(std::uint32_t id) const {
    const auto found = channels_.find(id);
    return found == channels_.end() ? nullptr : &found->second;
  }

 private:
  std::unordered_map<std::uint32_t, Channel> channels_;
};

}  // namespace cornerfix::cli
