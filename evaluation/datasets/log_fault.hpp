/// \file  Records of a log that could not be used: counted, the first few kept for the report.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace cornerfix::evaluation {

struct LogFault {
  std::string where;  ///< "line 3, byte 120", "byte 4117".
  std::string message;
};

/// Takes no more memory however many faults a log has.
class LogFaults {
 public:
  static constexpr std::size_t kKept = 5;

  void add(std::string where, std::string message) {
    ++count_;
    if (first_.size() < kKept) first_.push_back({std::move(where), std::move(message)});
  }

  /// As add(), where what could not be used was a scan.
  void add_scan(std::string where, std::string message) {
    ++scans_;
    add(std::move(where), std::move(message));
  }

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t scans() const { return scans_; }  ///< Of count().
  [[nodiscard]] std::span<const LogFault> first() const { return first_; }

 private:
  std::size_t count_ = 0;
  std::size_t scans_ = 0;
  std::vector<LogFault> first_;
};

}  // namespace cornerfix::evaluation
