#include "evaluation/metrics/localization_score.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "evaluation/metrics/evaluation_report.hpp"
#include "unit/evaluation/metrics/empty_map.hpp"

namespace cornerfix::evaluation {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A straight run, one scan per metre and second.
RecordedLog straight_run(std::size_t scans) {
  RecordedLog log;
  for (std::size_t i = 0; i < scans; ++i) {
    LogScan scan;
    scan.scan.stamp = static_cast<double>(i);
    scan.T_map_laser = Pose2{static_cast<double>(i), 0.0, 0.0};
    log.scans.push_back(scan);
  }
  return log;
}

std::vector<std::size_t> all_scans(const RecordedLog& log) {
  std::vector<std::size_t> indices(log.scans.size());
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  return indices;
}

/// Gives no pose for a while, then localizes with an error that grows with each answer.
ScoredRobot robot_that_drifts(const LocalizationMapPtr& map, int silent_scans, double error_m) {
  return [map, silent_scans, error_m, scan_count = 0](const RobotScan& scan) mutable {
    Answer answer;
    if (scan_count++ < silent_scans) return answer;
    answer.status = Status::kLocalized;
    answer.confidence = 0.999;
    answer.pose = LocalizedPose{map,
                                {scan.scan.stamp, error_m * (scan_count - silent_scans), 0.0},
                                {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    return answer;
  };
}

EvaluationOptions options_with(const ScoredRobot& robot) {
  EvaluationOptions options;
  options.batch = 1;
  options.max_distance_m = 5.0;
  options.make_robot = [robot](const LogScan&) { return robot; };
  return options;
}

TEST(CountableStarts, HaveTheDrivingOrTheTimeAhead) {
  const RecordedLog log = straight_run(10);
  EXPECT_THAT(countable_starts(log, all_scans(log), 7.0, 100.0), ElementsAre(0, 1, 2));
  EXPECT_THAT(countable_starts(log, all_scans(log), 100.0, 8.0), ElementsAre(0, 1));
  EXPECT_THAT(countable_starts(log, all_scans(log), 10.0, 100.0), IsEmpty());
}

TEST(CountableStarts, DoNotDriveAcrossAGap) {
  const RecordedLog log = straight_run(20);
  const std::vector<std::size_t> asking{0, 1, 2, 3, 10, 11, 12, 13, 14};
  EXPECT_THAT(countable_starts(log, asking, 3.0, 100.0), ElementsAre(0, 4, 5));
}

TEST(Evaluate, AsksOnlyStartsThatCount) {
  const RecordedLog log = straight_run(20);
  EvaluationOptions options = options_with([](const RobotScan&) { return Answer{}; });
  options.starts = 100;
  const auto records = evaluate(log, 0, {empty_map()}, 0, {}, options, nullptr);
  ASSERT_EQ(records.size(), 15U);
  for (const StartRecord& record : records) {
    EXPECT_TRUE(record.counts);
    EXPECT_GE(record.distance_traveled_m, 5.0);
  }
}

TEST(Evaluate, CountsNoStartOfALogThatIsTooShort) {
  const RecordedLog log = straight_run(4);
  const auto records = evaluate(log, 0, {empty_map()}, 0, {},
                                options_with([](const RobotScan&) { return Answer{}; }), nullptr);
  ASSERT_EQ(records.size(), 4U);
  for (const StartRecord& record : records) EXPECT_FALSE(record.counts);
}

TEST(Evaluate, CountsWrongAnswersLongAfterARightOne) {
  const RecordedLog log = straight_run(40);
  const LocalizationMapPtr map = empty_map();
  EvaluationOptions options = options_with(robot_that_drifts(map, 2, 0.1));
  options.starts = 1;
  options.track_m = 9.0;
  Evaluation evaluation;
  evaluation.map = map;
  evaluation.records = evaluate(log, 0, {map}, 0, {Point2::Zero()}, options, nullptr);
  ASSERT_EQ(evaluation.records.size(), 1U);
  const StartRecord& record = evaluation.records.front();
  EXPECT_EQ(record.verdict, Verdict::kCorrect);
  ASSERT_TRUE(record.first_wrong);
  EXPECT_EQ(record.first_wrong->distance_traveled_m, 7.0);
  EXPECT_EQ(record.withdrawal, Withdrawal::kLate);
  EXPECT_EQ(record.answers_judged, record.wrong_answers + 5);

  const auto summary = summary_json("log", evaluation, options);
  EXPECT_EQ(summary["starts"], 1);
  EXPECT_EQ(summary["false"], 0);
  EXPECT_EQ(summary["wrong_later"], 1);
  EXPECT_EQ(summary["starts_with_wrong_answer"], 1);
  EXPECT_EQ(summary["wrong_answers"], record.wrong_answers);
  EXPECT_EQ(summary["wrong_withdrawn"]["later_or_never"], 1);
  EXPECT_NEAR(summary["wrong_interval"][0].get<double>(), 0.025, 1e-9);
  EXPECT_EQ(record_json(record)["first_wrong"]["withdrawal"], "late");
}

TEST(Evaluate, FollowsAWrongPoseUntilItIsWithdrawnOrThreeMetresAreDriven) {
  const RecordedLog log = straight_run(40);
  const LocalizationMapPtr map = empty_map();
  EvaluationOptions options = options_with(robot_that_drifts(map, 2, 2.0));
  options.starts = 1;
  options.track_m = 0.0;
  const auto records = evaluate(log, 0, {map}, 0, {Point2::Zero()}, options, nullptr);
  EXPECT_EQ(records.front().verdict, Verdict::kWrong);
  EXPECT_EQ(records.front().withdrawal, Withdrawal::kLate);
  EXPECT_EQ(records.front().distance_traveled_m, 6.0);
}

}  // namespace
}  // namespace cornerfix::evaluation
