#include "server/request_rate.hpp"

#include <algorithm>
#include <cmath>

namespace cornerfix::server {
namespace {

using FloatSeconds = std::chrono::duration<double>;
constexpr std::size_t kMaxBuckets = 20'000;

}  // namespace

std::optional<std::chrono::seconds> RequestRate::must_wait(std::string_view caller,
                                                           Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  auto found = buckets_.find(caller);
  if (found == buckets_.end()) {
    if (buckets_.size() >= kMaxBuckets) make_room(now);
    found = buckets_.emplace(caller, Bucket{per_second_, now}).first;
  }
  Bucket& bucket = found->second;
  const double refill = per_second_ * FloatSeconds(now - bucket.filled).count();
  bucket = {std::min(per_second_, bucket.left + refill), now};
  if (bucket.left < 1.0)
    return std::chrono::ceil<std::chrono::seconds>(FloatSeconds((1.0 - bucket.left) / per_second_));
  bucket.left -= 1.0;
  return std::nullopt;
}

/// A bucket that is full again is as good as none.
void RequestRate::make_room(Clock::time_point now) {
  std::erase_if(buckets_, [&](const auto& entry) {
    return now - entry.second.filled >= std::chrono::seconds(1);
  });
  if (buckets_.size() >= kMaxBuckets) buckets_.clear();
}

}  // namespace cornerfix::server
