#include "evaluation/metrics/answer_judge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "unit/evaluation/metrics/empty_map.hpp"

namespace cornerfix::evaluation {
namespace {

using ::testing::DoubleEq;
using ::testing::Optional;

/// A robot that drives along x; its answers are judged against that.
class Robot {
 public:
  explicit Robot(LocalizationMapPtr map) : map_(std::move(map)), judge(map_) {}

  void localized(double x, double error_m, bool exact = true, double error_rad = 0.0) {
    Answer answer;
    answer.status = Status::kLocalized;
    answer.confidence = 0.999;
    answer.pose =
        LocalizedPose{map_, {x + error_m, 0.0, error_rad}, {0.04, 0, 0, 0, 0.04, 0, 0, 0, 0.01}};
    judge.take(answer, {x, 0.0, 0.0}, exact, x);
  }

  void silent(double x, Status status = Status::kLost) {
    Answer answer;
    answer.status = status;
    judge.take(answer, {x, 0.0, 0.0}, true, x);
  }

 private:
  LocalizationMapPtr map_;

 public:
  AnswerJudge judge;
};

TEST(AnswerJudge, CountsAWrongAnswerAfterARightOne) {
  Robot robot(empty_map());
  robot.localized(1.0, 0.1);
  robot.localized(2.0, 0.8);
  robot.localized(3.0, 0.9);
  robot.judge.finish();
  EXPECT_EQ(robot.judge.judged(), 3U);
  EXPECT_EQ(robot.judge.wrong(), 2U);
  ASSERT_TRUE(robot.judge.first() && robot.judge.first_wrong());
  EXPECT_TRUE(robot.judge.first()->correct);
  EXPECT_EQ(robot.judge.first_wrong()->distance_traveled_m, 2.0);
  EXPECT_DOUBLE_EQ(robot.judge.first_wrong()->error.m, 0.8);
}

TEST(AnswerJudge, HoldsAHeadingOfMoreThanFiveDegreesForWrong) {
  Robot robot(empty_map());
  robot.localized(1.0, 0.0, true, 0.08);
  EXPECT_EQ(robot.judge.wrong(), 0U);
  robot.localized(2.0, 0.0, true, 0.10);
  EXPECT_EQ(robot.judge.wrong(), 1U);
}

TEST(AnswerJudge, CountsEveryAnswerAsWrongWhenNoMapHoldsTheSurroundings) {
  const LocalizationMapPtr map = empty_map();
  AnswerJudge judge(nullptr);
  Answer answer;
  answer.status = Status::kLocalized;
  answer.pose = LocalizedPose{map, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  judge.take(answer, {}, true, 0.0);
  EXPECT_EQ(judge.wrong(), 1U);
}

TEST(AnswerJudge, HoldsAPoseInAnotherMapForWrong) {
  Robot robot(empty_map());
  Answer answer;
  answer.status = Status::kLocalized;
  answer.pose = LocalizedPose{empty_map(), {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  robot.judge.take(answer, {}, true, 0.0);
  EXPECT_EQ(robot.judge.wrong(), 1U);
}

TEST(AnswerJudge, MeasuresTheDrivingUntilAWrongPoseIsWithdrawn) {
  Robot robot(empty_map());
  robot.localized(1.0, 2.0);
  EXPECT_EQ(robot.judge.withdrawal(), Withdrawal::kUndecided);
  robot.localized(2.0, 2.0);
  robot.silent(3.5);
  EXPECT_EQ(robot.judge.longest_wrong_m(), 2.5);
  EXPECT_EQ(robot.judge.withdrawal(), Withdrawal::kInTime);
  robot.localized(9.0, 0.0);
  EXPECT_EQ(robot.judge.longest_wrong_m(), 2.5);
}

TEST(AnswerJudge, TakesACorrectedPoseForAWithdrawnOne) {
  Robot robot(empty_map());
  robot.localized(1.0, 2.0);
  robot.localized(3.0, 0.1);
  EXPECT_EQ(robot.judge.longest_wrong_m(), 2.0);
  EXPECT_EQ(robot.judge.withdrawal(), Withdrawal::kInTime);
}

TEST(AnswerJudge, FindsAPoseThatIsKeptForMoreThanThreeMetresLate) {
  Robot robot(empty_map());
  robot.localized(1.0, 2.0);
  robot.localized(3.9, 2.0);
  EXPECT_EQ(robot.judge.withdrawal(), Withdrawal::kUndecided);
  robot.localized(4.1, 2.0);
  EXPECT_EQ(robot.judge.withdrawal(), Withdrawal::kLate);
  robot.silent(5.0);
  EXPECT_EQ(robot.judge.withdrawal(), Withdrawal::kLate);
  EXPECT_EQ(robot.judge.longest_wrong_m(), 4.0);
}

TEST(AnswerJudge, FindsAnyWrongPoseLateNotOnlyTheFirst) {
  Robot robot(empty_map());
  robot.localized(1.0, 2.0);
  robot.localized(1.5, 0.0);
  robot.localized(2.0, 2.0);
  EXPECT_EQ(robot.judge.withdrawal(), Withdrawal::kUndecided);
  robot.localized(6.0, 2.0);
  EXPECT_EQ(robot.judge.withdrawal(), Withdrawal::kLate);
  EXPECT_EQ(robot.judge.longest_wrong_m(), 4.0);
  EXPECT_EQ(robot.judge.first_wrong()->distance_traveled_m, 1.0);
}

TEST(AnswerJudge, JudgesAtTheNextKeyframeInALogThatHasThem) {
  Robot robot(empty_map());
  robot.localized(1.0, 0.0, false, 0.2);
  EXPECT_TRUE(robot.judge.is_pending());
  EXPECT_EQ(robot.judge.judged(), 0U);
  EXPECT_THAT(robot.judge.localized_at_m(), Optional(DoubleEq(1.0)));
  robot.localized(1.2, 0.1, true);
  EXPECT_FALSE(robot.judge.is_pending());
  EXPECT_EQ(robot.judge.judged(), 1U);
  EXPECT_EQ(robot.judge.wrong(), 0U);
}

TEST(AnswerJudge, JudgesLooselyWhatNoKeyframeFollows) {
  Robot robot(empty_map());
  robot.localized(1.0, 0.0, false, 0.2);
  robot.silent(1.1);
  EXPECT_EQ(robot.judge.judged(), 1U);
  EXPECT_EQ(robot.judge.wrong(), 0U);
  robot.localized(2.0, 0.0, false, 0.3);
  robot.judge.finish();
  EXPECT_EQ(robot.judge.judged(), 2U);
  EXPECT_EQ(robot.judge.wrong(), 1U);
}

TEST(AnswerJudge, WeighsErrorsByTheCovarianceOfTheAnswer) {
  Robot robot(empty_map());
  robot.localized(1.0, 0.1);
  robot.localized(2.0, 0.2, true, 0.05);
  ASSERT_EQ(robot.judge.nees_after_first().size(), 1U);
  EXPECT_NEAR(robot.judge.nees_after_first().front(), 0.04 / 0.04 + 0.0025 / 0.01, 1e-12);
}

TEST(AnswerJudge, JudgesNothingOfARobotThatStaysSilent) {
  Robot robot(empty_map());
  robot.silent(0.0, Status::kCollecting);
  robot.silent(5.0, Status::kAmbiguous);
  robot.judge.finish();
  EXPECT_EQ(robot.judge.judged(), 0U);
  EXPECT_EQ(robot.judge.localized_at_m(), std::nullopt);
  EXPECT_EQ(robot.judge.first(), std::nullopt);
}

}  // namespace
}  // namespace cornerfix::evaluation
