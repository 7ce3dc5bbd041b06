#include <cornerfix/localizer.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "unit/core/localizer/localizer_runs.hpp"

namespace cornerfix {
namespace {

using namespace localizer_tests;

// --- The rest of an answer

TEST(Localizer, CovarianceIsSymmetricAndPositive) {
  const std::vector<Answer> answers =
      answers_of({room_map(17)}, with(Method::kIndexed), room_drive(17, 15));
  ASSERT_EQ(answers.back().status, Status::kLocalized);
  for (const Answer& answer : answers) {
    if (!answer.pose) continue;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> covariance(
        answer.pose->covariance.data());
    EXPECT_LT((covariance - covariance.transpose()).norm(), 1e-12);
    EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(covariance).info(), Eigen::Success);
    EXPECT_LT(std::sqrt(covariance(0, 0)), 0.2);
    EXPECT_LT(std::sqrt(covariance(1, 1)), 0.2);
    EXPECT_LT(std::sqrt(covariance(2, 2)), 0.1);
  }
}

TEST(Localizer, ALocalizedAnswerNamesItsPlaceFirst) {
  const Answer answer =
      answers_of({room_map(17)}, with(Method::kIndexed), room_drive(17, 15)).back();
  ASSERT_TRUE(answer.pose.has_value());
  ASSERT_FALSE(answer.hypotheses.empty());
  EXPECT_EQ(answer.hypotheses.front().T_map_base_link, answer.pose->T_map_base_link);
  EXPECT_EQ(answer.hypotheses.front().map, answer.pose->map);
  EXPECT_GT(answer.hypotheses.front().score, 0.5);
  EXPECT_EQ(answer.reason, Reason::kNone);
}

TEST(Localizer, HypothesesComeBestFirstAndAreScored) {
  const SceneBuilder room = SceneBuilder().room({-4, -2.5}, {4, 2.5});
  const std::vector<Moment> moments =
      drive(room, {}, testing::wander(room, {1.0, 0.3, 1.0}, 10), 1);
  std::size_t most = 0;
  for (const Answer& answer :
       answers_of({testing::make_map(room, {0.0, 0.0})}, with(Method::kIndexed), moments)) {
    most = std::max(most, answer.hypotheses.size());
    EXPECT_TRUE(std::ranges::is_sorted(answer.hypotheses, std::ranges::greater{},
                                       [](const auto& one) { return one.evidence.fit; }));
    for (const RankedHypothesis& hypothesis : answer.hypotheses) {
      EXPECT_GE(hypothesis.score, 0.0);
      EXPECT_LE(hypothesis.score, 1.0);
      EXPECT_NE(hypothesis.map, nullptr);
    }
  }
  EXPECT_GE(most, 2U) << "a rectangular room looks the same from two poses";
}

TEST(Localizer, ReportsItsSubmap) {
  const std::vector<Moment> moments = room_drive(18, 15);
  Localizer localizer({}, {});
  const Answer answer = answers_of(localizer, moments).back();
  EXPECT_GT(answer.local_scans, 5);
  EXPECT_GT(answer.local_features, 3);
  EXPECT_EQ(localizer.local_features_base_link().size(),
            static_cast<std::size_t>(answer.local_features));
  EXPECT_THAT(answer.T_submap_base_link,
              IsPoseNear(inverse(moments.front().T_map_base_link) * moments.back().T_map_base_link,
                         0.1, 0.03));
  EXPECT_EQ(localizer.last_stamp(), moments.back().scan.scan.stamp);
}

TEST(Localizer, TimesItsStepsByTheClockItIsGiven) {
  double now = 0.0;
  Localizer timed({}, {}, [&now] { return now += 1.0; });
  const Answer answer = timed.process(room_drive(18, 1).front().scan);
  EXPECT_GT(answer.times.odometry_ms, 0.0);
  EXPECT_GT(answer.times.extract_ms, 0.0);
  EXPECT_GE(answer.times.total_ms, answer.times.odometry_ms + answer.times.extract_ms +
                                       answer.times.match_ms + answer.times.verify_ms +
                                       answer.times.track_ms);
}

TEST(Localizer, WithoutAClockTimesAreZero) {
  Localizer localizer({}, {});
  EXPECT_EQ(localizer.process(room_drive(18, 1).front().scan).times.total_ms, 0.0);
}

}  // namespace
}  // namespace cornerfix
