/// \file  Key frames by the drive that took them, so that a building mapped again is told from one
/// that is mapped on.
#pragma once

#include <span>
#include <vector>

#include <cornerfix/laser_scan.hpp>

namespace cornerfix {

/// Whether a key frame begins another drive than the one before it: their stamps are more than five
/// minutes apart, forwards or back. The stamps of one drive follow each other; a few out of order,
/// as of two lidars, are still one drive.
[[nodiscard]] bool begins_drive(const PosedScan& before, const PosedScan& key_frame);

/// The key frames, in their order, cut where a drive begins. O(key frames).
[[nodiscard]] std::vector<std::span<const PosedScan>> drives_of(
    std::span<const PosedScan> key_frames);

}  // namespace cornerfix
