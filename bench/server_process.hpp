/// \file  `cornerfix serve` as a process of its own, for benchmarks.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace cornerfix::bench {

/// The program beside this one, on a free port. Ends with this object. An exit when it does not
/// start.
class ServerProcess {
 public:
  /// Returns when it serves.
  explicit ServerProcess(const std::filesystem::path& database);
  ~ServerProcess();
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  [[nodiscard]] const std::string& url() const { return url_; }
  /// Processor time of all its threads so far.
  [[nodiscard]] double processor_ms() const;
  [[nodiscard]] double resident_mb() const;

 private:
  pid_t pid_ = -1;
  std::string url_;
};

}  // namespace cornerfix::bench
