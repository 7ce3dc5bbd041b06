/// \file  Which topic and type the numbers of a bag's channels stand for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "evaluation/datasets/bag/ros_messages.hpp"
#include "evaluation/datasets/bag/wire_reader.hpp"

namespace cornerfix::evaluation {

/// A topic of a bag, of any type, and how many of its messages were passed so far.
struct BagTopic {
  std::string name;
  std::string type;
  std::size_t messages = 0;
};

/// What all messages of a channel share. ROS 1 calls it a connection.
struct Channel {
  BagTopic topic;
  std::optional<MessageKind> kind;  ///< Nothing when it is of no use here.
  WireFormat format = WireFormat::kRos1;
};

class ChannelTable {
 public:
  /// A channel that is known keeps its count. With an encoding that cannot be read here its type
  /// reads "sensor_msgs/LaserScan as json".
  void add(std::uint32_t id, std::string_view topic, std::string_view type,
           std::string_view encoding) {
    const std::optional<WireFormat> format = wire_format(encoding);
    Channel& channel = channels_[id];
    channel.topic.name = topic;
    channel.topic.type = type;
    if (!format) channel.topic.type += " as " + std::string(encoding);
    channel.kind = format ? message_kind(type) : std::nullopt;
    channel.format = format.value_or(WireFormat::kRos1);
  }

  /// The channel of a message that was passed, or nothing when the message is of no use.
  [[nodiscard]] const Channel* pass(std::uint32_t id) {
    const auto found = channels_.find(id);
    if (found == channels_.end()) return nullptr;
    ++found->second.topic.messages;
    return found->second.kind ? &found->second : nullptr;
  }

  [[nodiscard]] std::vector<BagTopic> topics() const {
    std::vector<BagTopic> topics;
    for (const auto& [id, channel] : channels_) topics.push_back(channel.topic);
    return topics;
  }

 private:
  static std::optional<WireFormat> wire_format(std::string_view encoding) {
    if (encoding == "cdr") return WireFormat::kCdr;
    if (encoding == "ros1") return WireFormat::kRos1;
    return std::nullopt;
  }

  std::map<std::uint32_t, Channel> channels_;
};

}  // namespace cornerfix::evaluation
