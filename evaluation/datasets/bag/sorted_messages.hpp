/// \file  The messages of a bag that is not in the order of its time.
#pragma once

#include <functional>
#include <memory>

#include "evaluation/datasets/bag/message_source.hpp"

namespace cornerfix::evaluation {

/// All messages of use, by the time of recording. The first call of next() reads `messages` to the
/// end and keeps up to 2 GiB; what is behind that is left out, and a fault.
[[nodiscard]] std::unique_ptr<MessageSource> sorted_by_time(
    std::unique_ptr<MessageSource> messages, std::function<bool(const RecordedMessage&)> is_of_use);

}  // namespace cornerfix::evaluation
