/// \file  How many requests per second a caller may send.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace cornerfix::server {

/// A bucket per caller that holds the requests of one second and refills evenly. Any threads may
/// call.
class RequestRate {
 public:
  using Clock = std::chrono::steady_clock;

  explicit RequestRate(std::size_t per_second) : per_second_(static_cast<double>(per_second)) {}

  /// Counts a request. How long the caller must wait instead, when it has sent too many.
  [[nodiscard]] std::optional<std::chrono::seconds> must_wait(std::string_view caller,
                                                              Clock::time_point now);

 private:
  struct Bucket {
    double left = 0.0;
    Clock::time_point filled{};
  };

  void make_room(Clock::time_point now);

  const double per_second_;
  std::mutex mutex_;
  std::map<std::string, Bucket, std::less<>> buckets_;
};

}  // namespace cornerfix::server
