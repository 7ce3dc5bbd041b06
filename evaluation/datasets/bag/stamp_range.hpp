/// \file  From which time to which, for people.
#pragma once

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>

namespace cornerfix::evaluation {

class StampRange {
 public:
  void add(double stamp) {
    first_ = std::min(first_, stamp);
    last_ = std::max(last_, stamp);
  }

  [[nodiscard]] bool is_empty() const { return first_ > last_; }

  /// "12.000 to 29.500 s".
  [[nodiscard]] std::string text() const {
    char text[96];
    std::snprintf(text, sizeof text, "%.3f to %.3f s", first_, last_);
    return text;
  }

 private:
  double first_ = std::numeric_limits<double>::infinity();
  double last_ = -std::numeric_limits<double>::infinity();
};

}  // namespace cornerfix::evaluation
