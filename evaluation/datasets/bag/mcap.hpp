/// \file  MCAP files, of ROS 2 and ROS 1: https://mcap.dev/spec.
#pragma once

#include <filesystem>
#include <memory>

#include <cornerfix/result.hpp>

#include "evaluation/datasets/bag/message_source.hpp"

namespace cornerfix::evaluation {

/// Reads from front to back without the index, so that a file that was never closed can be read as
/// well; holds one chunk of it. Chunks may be packed with lz4 or zstd. A chunk that is damaged is
/// left out; behind a record whose length is wrong nothing can be read.
[[nodiscard]] Result<std::unique_ptr<MessageSource>> open_mcap_messages(
    const std::filesystem::path& path);

}  // namespace cornerfix::evaluation
