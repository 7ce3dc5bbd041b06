/// \file  Sums over many rows of bytes at once, a strip of places side by side at a time.
///
/// The innermost loop of the search through a whole map: written so that the compiler takes 16 or
/// 32 places in one instruction, by what the processor can do.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace cornerfix {

inline constexpr std::size_t kStrip = 32;  ///< Places side by side.
inline constexpr std::size_t kGroup = 8;   ///< Sources whose sum must fit a byte.

using StripSums = std::array<std::uint16_t, kStrip>;

/// Some of the sources, and what they and those before them must sum up to.
struct SumStep {
  std::span<const std::uint8_t* const> sources;  ///< A multiple of kGroup.
  int least = 0;
};

/// sums[i] = the sum of source[shift + i] over the sources of all steps, given up after a step when
/// no sum whose flag, flags[shift + i], is `wanted` reaches what it must.
/// \param groups  Increased by the groups of sources that were summed.
/// \return Whether one does, to the last step; if not, the sums are undefined.
bool sum_strip(std::span<const SumStep> steps, const std::uint8_t* flags, std::uint8_t wanted,
               std::size_t shift, StripSums& sums, std::size_t& groups);

}  // namespace cornerfix
