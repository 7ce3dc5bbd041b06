/// \file  What a kind of bag must be able to do: give out its messages one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <cornerfix/result.hpp>

#include "evaluation/datasets/bag/channel_table.hpp"
#include "evaluation/datasets/bag/ros_messages.hpp"
#include "evaluation/datasets/log_fault.hpp"

namespace cornerfix::evaluation {

struct RecordedMessage {
  std::string topic;
  std::string type;
  MessageKind kind = MessageKind::kLaserScan;
  WireFormat format = WireFormat::kRos1;
  double received = 0.0;             ///< When it was recorded [s].
  std::span<const std::byte> bytes;  ///< Until the next call of next().
  std::string where;                 ///< "byte 4117": of the record, or of the chunk that holds it.
};

class MessageSource {
 public:
  virtual ~MessageSource() = default;

  /// The next message of a kind of use here, or nothing at the end of what can be read. What is
  /// broken is added to `faults` and left out.
  [[nodiscard]] virtual std::optional<RecordedMessage> next(LogFaults& faults) = 0;
  /// Share of the bag read so far, in [0, 1].
  [[nodiscard]] virtual double progress() const = 0;
  /// All topics seen so far, also those of no use here.
  [[nodiscard]] virtual std::vector<BagTopic> topics() const = 0;
};

}  // namespace cornerfix::evaluation
