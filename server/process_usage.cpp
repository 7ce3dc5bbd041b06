#include "server/process_usage.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <system_error>

namespace cornerfix::server {
namespace {

namespace fs = std::filesystem;

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t pages = 0;
  file >> pages >> pages;  // The second is the resident set (proc(5)).
  return file ? pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

std::uint64_t count_descriptors() {
  std::error_code error;
  const fs::directory_iterator first("/proc/self/fd", error);
  return error ? 0 : static_cast<std::uint64_t>(std::distance(first, fs::directory_iterator()));
}

std::uint64_t size_of(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  return error ? 0 : size;
}

}  // namespace

ProcessUsage process_usage() {
  ProcessUsage usage;
  rusage used{};
  if (getrusage(RUSAGE_SELF, &used) == 0)
    usage.cpu_s = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0) usage.max_descriptors = limit.rlim_cur;
  usage.resident_bytes = resident_bytes();
  usage.open_descriptors = count_descriptors();
  return usage;
}

DatabaseUsage database_usage(const fs::path& database) {
  std::error_code error;
  const fs::space_info space = fs::space(database, error);
  return {.file_bytes = size_of(database),
          .wal_bytes = size_of(fs::path(database) += "-wal"),
          .disk_free_bytes = error ? 0 : space.available};
}

}  // namespace cornerfix::server
