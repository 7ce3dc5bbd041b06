/// \file  Keyframes by the run that took them, so that a building mapped again differs from one
/// whose mapping continues.
#pragma once

#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

/// Whether a keyframe begins another run than the one before it: their stamps are more than five
/// minutes apart, forwards or back. The stamps of one run follow each other; a few out of order, as
/// of two lidars, are still one run.
[[nodiscard]] bool begins_drive(const PosedScan& before, const PosedScan& key_frame);

/// The keyframes, in their order, cut where a run begins. O(keyframes).
[[nodiscard]] std::vector<std::span<const PosedScan>> drives_of(
    std::span<const PosedScan> key_frames);

}  // namespace cornerfix
