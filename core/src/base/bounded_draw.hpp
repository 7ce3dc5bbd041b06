/// \file  Random integers that are the same with every standard library, which those of
/// std::uniform_int_distribution are not.
#pragma once

#include <cassert>
#include <cstddef>
#include <limits>
#include <random>

namespace cornerfix {

/// Uniform in [0, bound), bound > 0.
inline std::size_t bounded_draw(std::mt19937_64& random, std::size_t bound) {
  assert(bound > 0 && "nothing to draw from");
  constexpr auto kMax = std::numeric_limits<std::uint64_t>::max();
  const std::uint64_t unbiased = kMax - kMax % bound;  // A multiple of bound.
  std::uint64_t draw = random();
  while (draw >= unbiased) draw = random();
  return draw % bound;
}

}  // namespace cornerfix
