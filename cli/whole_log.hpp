/// \file  A recorded run read into memory the way commands do it: people see how far it is, and
/// what they should know of the log.
#pragma once

#include <cstddef>
#include <string>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::cli {

/// An error as well when most of its scans cannot be used.
/// \param stride  n keeps every n-th scan, from the first.
[[nodiscard]] Result<evaluation::RecordedLog> read_whole_log(
    const std::string& path, const evaluation::LogSelection& selection, std::size_t stride = 1);

}  // namespace cornerfix::cli
