/// \file  Random numbers that are the same on every platform: the distributions of the standard
/// library are not specified to the bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

namespace cornerfix::evaluation {

/// Same seed and stream, same numbers. Streams of one seed are independent, so that drawing more
/// from one leaves the others as they were.
class SeededRandom {
 public:
  explicit SeededRandom(std::uint64_t seed, std::uint32_t stream = 0) {
    std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                           stream};
    engine_.seed(sequence);
  }

  /// In [low, high).
  [[nodiscard]] double uniform(double low, double high) {
    constexpr double kUnit = 0x1p-53;
    return low + (high - low) * kUnit * static_cast<double>(engine_() >> 11);
  }

  /// In [low, high], both included; low <= high.
  [[nodiscard]] int integer(int low, int high) {
    return low + static_cast<int>(uniform(0.0, 1.0) * (static_cast<double>(high) - low + 1.0));
  }

  [[nodiscard]] bool chance(double probability) { return uniform(0.0, 1.0) < probability; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace cornerfix::evaluation
