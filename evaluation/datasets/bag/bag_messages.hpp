/// \file  The messages of a bag of any kind.
#pragma once

#include <filesystem>
#include <memory>

#include <cornerfix/result.hpp>

#include "evaluation/datasets/bag/bag_files.hpp"
#include "evaluation/datasets/bag/message_source.hpp"

namespace cornerfix::evaluation {

/// One file after the other. Files packed with zstd are unpacked to a temporary file each, packed
/// messages in memory. A file that cannot be opened is an error when it is the first, else a fault.
[[nodiscard]] Result<std::unique_ptr<MessageSource>> open_bag_messages(const BagFiles& bag);

}  // namespace cornerfix::evaluation
