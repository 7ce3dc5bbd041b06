#include "core/src/base/in_parallel.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace cornerfix {
namespace {

TEST(InParallel, DoesAllOfItOnce) {
  for (const std::size_t count : {0U, 1U, 2U, 1000U}) {
    std::vector<int> calls(count, 0);
    for_each_in_parallel(count, [&](std::size_t i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(count, 1));
  }
}

TEST(InParallel, TellsTheCallerWhatWasThrown) {
  const auto fail_at_seven = [](std::size_t i) {
    if (i == 7) throw std::runtime_error("seven");
  };
  EXPECT_THROW(for_each_in_parallel(1000, fail_at_seven), std::runtime_error);
}

}  // namespace
}  // namespace cornerfix
