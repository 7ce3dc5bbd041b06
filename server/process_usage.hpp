/// \file  What the process uses of the machine, as the operating system counts it.
#pragma once

#include <cstdint>
#include <filesystem>

namespace cornerfix::server {

/// Zeros where /proc cannot be read.
struct ProcessUsage {
  double cpu_s = 0.0;
  std::uint64_t resident_bytes = 0;
  std::uint64_t open_descriptors = 0;
  std::uint64_t max_descriptors = 0;
};
[[nodiscard]] ProcessUsage process_usage();

/// Sizes of a database's files; zeros for what is not there.
struct DatabaseUsage {
  std::uint64_t file_bytes = 0;
  std::uint64_t wal_bytes = 0;
  std::uint64_t disk_free_bytes = 0;
};
[[nodiscard]] DatabaseUsage database_usage(const std::filesystem::path& database);

}  // namespace cornerfix::server
