/// \file  ROS 1 bags: http://wiki.ros.org/Bags/Format/2.0.
#pragma once

#include <filesystem>
#include <memory>

#include <cornerfix/result.hpp>

#include "evaluation/datasets/bag/message_source.hpp"

namespace cornerfix::evaluation {

/// Reads from front to back without the index, so that a bag that was never closed can be read as
/// well; holds one chunk of it. Chunks may be packed with bz2 or lz4. A chunk that is damaged is
/// left out; behind a record whose lengths are wrong nothing can be read.
[[nodiscard]] Result<std::unique_ptr<MessageSource>> open_ros1_messages(
    const std::filesystem::path& path);

}  // namespace cornerfix::evaluation
