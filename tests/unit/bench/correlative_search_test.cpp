#include "bench/rivals/correlative_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/src/search/map_index.hpp"
#include "support/matchers.hpp"
#include "tests/unit/bench/mapped_offices.hpp"

namespace cornerfix::bench {
namespace {

const CorrelativeSearch& office_search() {
  static const CorrelativeSearch search(testing::office_map()->grid(),
                                        testing::office_map()->index().field);
  return search;
}

TEST(CorrelativeSearch, FindsTheRobotAnywhereInTheMap) {
  for (const Pose2& truth : {Pose2{2.0, 4.0, 0.3}, Pose2{7.0, 4.0, -2.0}, Pose2{13.0, 3.5, 3.0}}) {
    const auto found = office_search().find(testing::ends_seen(truth));
    ASSERT_TRUE(found) << truth.x << ", " << truth.y;
    EXPECT_THAT(*found, cornerfix::testing::IsPoseNear(truth, 0.05, 0.02));
  }
}

TEST(CorrelativeSearch, SaysNothingWhereTooLittleIsExplained) {
  std::vector<Point2> circle;
  for (int i = 0; i < 100; ++i)
    circle.emplace_back(2.0 * std::cos(0.06 * i), 2.0 * std::sin(0.06 * i));
  EXPECT_FALSE(office_search().find(circle));
}

TEST(CorrelativeSearch, SaysNothingWithoutReturns) { EXPECT_FALSE(office_search().find({})); }

}  // namespace
}  // namespace cornerfix::bench
