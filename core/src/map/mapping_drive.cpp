#include "core/src/map/mapping_drive.hpp"

#include <cmath>
#include <cstddef>

namespace cornerfix {

namespace {

constexpr double kLongestPauseS = 300.0;  // recorded runs that stop to look make it 230 s

}  // namespace

bool begins_drive(const PosedScan& before, const PosedScan& key_frame) {
  return std::abs(key_frame.scan.stamp - before.scan.stamp) > kLongestPauseS;
}

std::vector<std::span<const PosedScan>> drives_of(std::span<const PosedScan> key_frames) {
  std::vector<std::span<const PosedScan>> drives;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= key_frames.size(); ++i) {
    if (i < key_frames.size() && !begins_drive(key_frames[i - 1], key_frames[i])) continue;
    drives.push_back(key_frames.subspan(first, i - first));
    first = i;
  }
  return drives;
}

}  // namespace cornerfix
