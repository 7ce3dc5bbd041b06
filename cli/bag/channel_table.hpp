/// \file  Which topic and type the numbers of a bag's channels stand for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/bag/ros_messages.hpp"
#include "cli/bag/wire_reader.hpp"

namespace cornerfix::cli {

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
  /// `format` is nothing for a serialization that cannot be read here. A channel that is known
  /// keeps its count.
  void add(std::uint32_t id, std::string_view topic, std::string_view type,
           std::optional<WireFormat> format) {
    Channel& channel = channels_[id];
    channel.topic.name = topic;
    channel.topic.type = type;
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
  std::map<std::uint32_t, Channel> channels_;
};

}  // namespace cornerfix::cli
