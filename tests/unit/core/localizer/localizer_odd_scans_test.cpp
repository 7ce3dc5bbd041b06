#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "unit/core/localizer/localizer_runs.hpp"

namespace cornerfix {
namespace {

using namespace localizer_tests;

// --- Scans that say nothing

constexpr float kNullRange = std::numeric_limits<float>::quiet_NaN();

struct OddScan {
  const char* name;
  std::vector<float> ranges;
};

void PrintTo(const OddScan& odd, std::ostream* out) { *out << odd.name; }

class LocalizerWithOddScans : public ::testing::TestWithParam<OddScan> {};

RobotScan odd_scan(const std::vector<float>& ranges, double stamp) {
  return {{.stamp = stamp,
           .angle_min = -kPi,
           .angle_increment = 2.0 * kPi / 360.0,
           .range_min = 0.1,
           .range_max = 30.0,
           .ranges = ranges},
          {},
          {}};
}

TEST_P(LocalizerWithOddScans, IsCollectingWithAReason) {
  const LocalizationMapPtr map = room_map(16);
  for (const Method method : kMethods) {
    Localizer localizer({map}, with(method));
    for (int i = 0; i < 8; ++i) {
      RobotScan scan = odd_scan(GetParam().ranges, 1.0 + i);
      if (i % 2 == 0) scan.T_odom_base_link = Pose2{0.3 * i, 0.0, 0.1 * i};
      const Answer answer = localizer.process(scan);
      EXPECT_EQ(answer.status, Status::kCollecting) << to_string(method) << ", scan " << i;
      EXPECT_NE(answer.reason, Reason::kNone) << to_string(method) << ", scan " << i;
      EXPECT_FALSE(answer.pose.has_value());
    }
  }
}

TEST(LocalizerWithGeometryOfNan, TakesTheScanForOneWithoutReturns) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Moment> moments = room_drive(16, 20);
  moments[3].scan.scan.angle_min = kNan;
  moments[4].scan.scan.angle_increment = kNan;
  moments[5].scan.T_base_link_laser.x = kNan;
  moments[6].scan.T_base_link_laser.yaw = kNan;
  for (const Method method : kMethods) {
    Localizer localizer({room_map(16)}, with(method));
    EXPECT_EQ(count_wrong(answers_of(localizer, moments), moments), 0U) << to_string(method);
  }
}

TEST_P(LocalizerWithOddScans, DoesNotMisleadOneThatIsLocalized) {
  const std::vector<Moment> moments = room_drive(16, 20);
  Localizer localizer({room_map(16)}, with(Method::kIndexed));
  const std::vector<Moment> before(moments.begin(), moments.begin() + 12);
  const std::vector<Moment> after(moments.begin() + 12, moments.end());
  ASSERT_EQ(answers_of(localizer, before).back().status, Status::kLocalized);
  RobotScan odd = odd_scan(GetParam().ranges, before.back().scan.scan.stamp + 0.1);
  odd.T_odom_base_link = before.back().scan.T_odom_base_link;
  const Answer answer = localizer.process(odd);
  if (answer.pose) {
    EXPECT_THAT(answer.pose->T_map_base_link, IsPoseNear(before.back().T_map_base_link, 0.3, 0.1));
  }
  const std::vector<Answer> answers = answers_of(localizer, after);
  EXPECT_EQ(count_wrong(answers, after), 0U);
  expect_localized_at(answers.back(), after.back().T_map_base_link);
}

INSTANTIATE_TEST_SUITE_P(Localizer, LocalizerWithOddScans,
                         ::testing::Values(OddScan{"no_beams", {}}, OddScan{"one_beam", {2.0F}},
                                           OddScan{"two_beams", {2.0F, 2.1F}},
                                           OddScan{"all_null", std::vector<float>(360, kNullRange)},
                                           OddScan{"all_zero", std::vector<float>(360, 0.0F)},
                                           OddScan{"all_too_far", std::vector<float>(360, 31.0F)},
                                           OddScan{"all_equal", std::vector<float>(360, 2.0F)},
                                           OddScan{"all_equal_and_far",
                                                   std::vector<float>(360, 25.0F)}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Localizer, ACoveredLidarIsNeverLocalized) {
  const LocalizationMapPtr map = room_map(16);
  for (const Method method : kMethods) {
    Localizer localizer({map}, with(method));
    for (int i = 0; i < 8; ++i) {
      RobotScan scan = odd_scan(std::vector<float>(360, 0.1F), 1.0 + i);
      scan.T_odom_base_link = Pose2{0.3 * i, 0.0, 0.1 * i};
      EXPECT_NE(localizer.process(scan).status, Status::kLocalized) << to_string(method);
    }
  }
}

TEST(Localizer, WithoutAnyReturnTheReasonIsThat) {
  Localizer localizer({room_map(16)}, with(Method::kRma));
  const Answer answer = localizer.process(odd_scan(std::vector<float>(360, kNullRange), 1.0));
  EXPECT_EQ(answer.reason, Reason::kNoReturns);
}

}  // namespace
}  // namespace cornerfix
