#include "evaluation/datasets/constant_range.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace cornerfix::evaluation {

namespace {

constexpr std::size_t kMostFound = 3;
constexpr std::size_t kFewestHits = 5;   // of a scan
constexpr std::size_t kFewestScans = 5;  // of kScans
/// A wall that faces a robot at rest has its longest ranges at its ends, so few that are the same.
constexpr double kLeastShare = 0.02;  // of all beams
/// With hardly any other return there is nothing to compare with.
constexpr double kMostReturns = 0.95;

}  // namespace

void ConstantRange::look_at(const LaserScan& scan) {
  if (found_.size() == kMostFound) return;
  longest_.push_back(longest_of(scan));
  if (longest_.size() > kScans) longest_.pop_front();
  const float range = std::ranges::max_element(longest_, {}, &Longest::range)->range;
  Longest all;
  std::size_t scans = 0;
  for (const Longest& longest : longest_) {
    all.beams += longest.beams;
    all.returns += longest.returns;
    if (longest.range != range || longest.hits < kFewestHits) continue;
    all.hits += longest.hits;
    ++scans;
  }
  const auto hits = static_cast<double>(all.hits);
  if (scans < kFewestScans || hits < kLeastShare * static_cast<double>(all.beams)) return;
  if (hits > kMostReturns * static_cast<double>(all.returns)) return;
  found_.push_back(range);
  longest_.clear();
}

void ConstantRange::clear(LaserScan& scan) {
  if (found_.empty()) return;
  for (float& range : scan.ranges) {
    if (!is_found(range)) continue;
    range = std::numeric_limits<float>::quiet_NaN();
    ++cleared_;
  }
}

std::string ConstantRange::note() const {
  if (cleared_ == 0) return "";
  std::string ranges;
  for (const float range : found_) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", static_cast<double>(range));
    ranges += (ranges.empty() ? "" : ", ") + std::string(text);
  }
  return std::to_string(cleared_) + " ranges of exactly " + ranges +
         " m are taken for no returns: none is longer, and hits of a wall would differ";
}

ConstantRange::Longest ConstantRange::longest_of(const LaserScan& scan) const {
  Longest longest;
  longest.beams = scan.ranges.size();
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const float range = scan.ranges[beam];
    if (!scan.has_return(beam) || is_found(range)) continue;
    ++longest.returns;
    if (range > longest.range) {
      longest.range = range;
      longest.hits = 0;
    }
    longest.hits += range == longest.range ? 1 : 0;
  }
  return longest;
}

bool ConstantRange::is_found(float range) const {
  return std::ranges::find(found_, range) != found_.end();
}

}  // namespace cornerfix::evaluation
