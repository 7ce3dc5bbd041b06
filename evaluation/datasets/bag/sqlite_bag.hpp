/// \file  ROS 2 bags of the storage plugin sqlite3: tables `topics` and `messages` in a .db3 file.
/// The one place outside of storage that knows SQLite: a bag is no database of Cornerfix's.
#pragma once

#include <filesystem>
#include <memory>

#include <cornerfix/result.hpp>

#include "evaluation/datasets/bag/message_source.hpp"

namespace cornerfix::evaluation {

/// Opens read-only and steps through the messages in the order of recording, one in memory at a
/// time.
[[nodiscard]] Result<std::unique_ptr<MessageSource>> open_sqlite_messages(
    const std::filesystem::path& path);

}  // namespace cornerfix::evaluation
