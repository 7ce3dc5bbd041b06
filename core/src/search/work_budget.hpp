/// \file  A bound on the work of one scan. It counts operations and not time, so that answers do
/// not depend on the load of the machine.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace cornerfix {

/// Units are about 10 ns of one core (`cornerfix_micro_bench`, BM_SearchWork): sums of 8 points at
/// 32 poses.
class WorkBudget {
 public:
  static constexpr double kUnitsPerMs = 1e5;

  /// Without a bound.
  WorkBudget() = default;
  explicit WorkBudget(double nominal_ms)
      : left_(static_cast<std::int64_t>(std::min(nominal_ms * kUnitsPerMs, kMost))) {}

  void charge(std::size_t units) { left_ -= static_cast<std::int64_t>(units); }
  [[nodiscard]] bool is_spent() const { return left_ <= 0; }
  [[nodiscard]] std::int64_t left() const { return left_; }

 private:
  static constexpr double kMost = 1e18;
  std::int64_t left_ = std::numeric_limits<std::int64_t>::max();
};

}  // namespace cornerfix
