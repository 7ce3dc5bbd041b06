#include "core/src/base/cross.hpp"

#include <gtest/gtest.h>

namespace cornerfix {
namespace {

TEST(Cross, IsTwiceTheAreaOfTheTriangle) { EXPECT_DOUBLE_EQ(cross({3, 0}, {1, 2}), 6.0); }

TEST(Cross, IsNegativeForAVectorToTheRight) { EXPECT_DOUBLE_EQ(cross({1, 2}, {3, 0}), -6.0); }

TEST(Cross, IsZeroForParallelVectors) { EXPECT_DOUBLE_EQ(cross({1, 2}, {-2, -4}), 0.0); }

}  // namespace
}  // namespace cornerfix
