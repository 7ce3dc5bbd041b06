/// \file  Which answers may become a published pose.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "ros2/answer.hpp"
#include "ros2/bridge_options.hpp"

namespace cornerfix::ros2 {

/// Not synchronised.
class PoseGate {
 public:
  explicit PoseGate(PublishWhen when) : when_(when) {}

  /// Whether the answer has a pose that may be used.
  [[nodiscard]] bool is_open(const Answer& answer) const {
    return answer.pose && (when_ == PublishWhen::kLocalized || answer.pose->is_confirmed);
  }

  /// Whether the answer's pose must be published now: once per epoch of a session, and again for
  /// subscribers that come after there was none.
  [[nodiscard]] bool pass(const Answer& answer, bool has_subscriber) {
    if (!has_subscriber) published_.reset();
    if (!has_subscriber || !is_open(answer)) return false;
    const Epoch epoch{answer.session, answer.pose->epoch};
    return std::exchange(published_, epoch) != epoch;
  }

 private:
  using Epoch = std::pair<std::string, std::uint64_t>;  ///< With its session.

  PublishWhen when_;
  std::optional<Epoch> published_;
};

}  // namespace cornerfix::ros2
