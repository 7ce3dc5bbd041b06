#include "core/src/search/strip_sums.hpp"

#include <algorithm>

// Compiled twice, for processors with AVX2 and for those without; the loader chooses. Sanitizers
// are not ready yet when it does.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define CORNERFIX_WIDE_WHERE_POSSIBLE __attribute__((target_clones("avx2", "default")))
#else
#define CORNERFIX_WIDE_WHERE_POSSIBLE
#endif

namespace cornerfix {

CORNERFIX_WIDE_WHERE_POSSIBLE
bool sum_strip(std::span<const SumStep> steps, const std::uint8_t* flags, std::uint8_t wanted,
               std::size_t shift, StripSums& sums, std::size_t& groups) {
  static_assert(kGroup == 8);
  StripSums total{};
  for (const SumStep& step : steps) {
    for (std::size_t group = 0; group < step.sources.size(); group += kGroup) {
      const std::uint8_t* a = step.sources[group] + shift;
      const std::uint8_t* b = step.sources[group + 1] + shift;
      const std::uint8_t* c = step.sources[group + 2] + shift;
      const std::uint8_t* d = step.sources[group + 3] + shift;
      const std::uint8_t* e = step.sources[group + 4] + shift;
      const std::uint8_t* f = step.sources[group + 5] + shift;
      const std::uint8_t* g = step.sources[group + 6] + shift;
      const std::uint8_t* h = step.sources[group + 7] + shift;
      std::array<std::uint8_t, kStrip> of_group;
      for (std::size_t i = 0; i < kStrip; ++i) {
        of_group[i] =
            static_cast<std::uint8_t>(a[i] + b[i] + c[i] + d[i] + e[i] + f[i] + g[i] + h[i]);
      }
      for (std::size_t i = 0; i < kStrip; ++i)
        total[i] = static_cast<std::uint16_t>(total[i] + of_group[i]);
    }
    groups += step.sources.size() / kGroup;
    std::uint16_t highest = 0;
    for (std::size_t i = 0; i < kStrip; ++i) {
      // Without a branch, or the compiler takes them one by one.
      const auto mask = static_cast<std::uint16_t>(-static_cast<int>(flags[shift + i] == wanted));
      highest = std::max(highest, static_cast<std::uint16_t>(total[i] & mask));
    }
    if (highest < step.least) return false;
  }
  sums = total;
  return true;
}

}  // namespace cornerfix
