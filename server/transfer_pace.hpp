/// \file  How long bytes may take on their way.
#pragma once

#include <chrono>
#include <cstddef>

namespace cornerfix::server {

/// A transfer gets some seconds and, on top, the time that its bytes need at a minimum rate. A
/// client that sends or reads a byte now and then does not hold a connection.
class TransferPace {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TransferPace(Clock::time_point begin) : begin_(begin) {}

  void add(std::size_t bytes) { bytes_ += bytes; }
  /// When the next bytes must have come.
  [[nodiscard]] Clock::time_point deadline() const {
    return begin_ + kGrace + std::chrono::milliseconds(bytes_ / kMinBytesPerMillisecond);
  }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  [[nodiscard]] Clock::time_point begin() const { return begin_; }

 private:
  static constexpr std::chrono::seconds kGrace{5};
  static constexpr std::size_t kMinBytesPerMillisecond = 16;  // 16 kB/s

  Clock::time_point begin_;
  std::size_t bytes_ = 0;
};

}  // namespace cornerfix::server
