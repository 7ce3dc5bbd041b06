/// \file  Puts scans in order that were recorded a little out of order.
#pragma once

#include <cstddef>
#include <deque>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "evaluation/datasets/log_reader.hpp"
#include "evaluation/datasets/stamp_order.hpp"

namespace cornerfix::evaluation {

/// Holds a few scans back: two lidars on one topic and drivers with several threads change places.
/// A clock that was set back is not touched: see StampOrder.
class ScanQueue {
 public:
  [[nodiscard]] bool is_full() const { return scans_.size() > kHeldBack; }
  [[nodiscard]] bool is_empty() const { return scans_.empty(); }

  void push(LogScan scan) {
    auto place = scans_.end();
    while (place != scans_.begin() && comes_before(scan, *std::prev(place))) --place;
    sorted_ += place == scans_.end() ? 0 : 1;
    scans_.insert(place, std::move(scan));
  }

  [[nodiscard]] LogScan pop() {
    LogScan scan = std::move(scans_.front());
    scans_.pop_front();
    return scan;
  }

  /// Of the scan to come; nothing where there is none.
  [[nodiscard]] std::optional<double> next_stamp() const {
    return scans_.empty() ? std::nullopt : std::optional(scans_.front().scan.stamp);
  }

  /// What was done, for people; may be empty.
  [[nodiscard]] std::string note() const {
    if (sorted_ == 0) return "";
    return std::to_string(sorted_) + " scans were recorded out of order: they are sorted by stamp";
  }

 private:
  static constexpr std::size_t kHeldBack = 4;

  static bool comes_before(const LogScan& scan, const LogScan& other) {
    const double late = other.scan.stamp - scan.scan.stamp;
    return late > 0.0 && late <= StampOrder::kSetBackSeconds;
  }

  std::deque<LogScan> scans_;
  std::size_t sorted_ = 0;
};

}  // namespace cornerfix::evaluation
