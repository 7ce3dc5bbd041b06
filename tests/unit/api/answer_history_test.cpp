#include "api/answer_history.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>

namespace cornerfix::api {
namespace {

Answer collecting(Reason reason) {
  Answer answer;
  answer.reason = reason;
  answer.times.total_ms = 2.5;
  return answer;
}

TEST(AnswerHistory, KeepsTheNewestAnswersOldestFirst) {
  AnswerHistory history;
  const std::size_t added = AnswerHistory::kMaxAnswers + 7;
  for (std::uint64_t i = 0; i < added; ++i) history.add(collecting(Reason::kNoMotion), i, "t");
  ASSERT_EQ(history.answers().size(), AnswerHistory::kMaxAnswers);
  EXPECT_EQ(history.answers().front().sequence, 7U);
  EXPECT_EQ(history.answers().back().sequence, added - 1);
}

TEST(AnswerHistory, IsRenderedWithoutAPoseUnlessLocalized) {
  AnswerHistory history;
  history.add(collecting(Reason::kFewFeatures), 0, "2026-11-29T03:00:00Z");
  EXPECT_EQ(render_history("s-1", history.answers()).dump(), Json::parse(R"({
    "session": "s-1", "answers": [
      {"sequence": 0, "received": "2026-11-29T03:00:00Z", "status": "collecting",
       "reason": "few_features", "pose": null, "confidence": 0.0,
       "timing_ms": {"odometry": 0.0, "extract": 0.0, "match": 0.0, "verify": 0.0, "track": 0.0,
                     "total": 2.5}}]})")
                                                                 .dump());
}

TEST(AnswerHistory, KeepsThePoseOfALocalizedRobot) {
  Answer answer;
  answer.status = Status::kLocalized;
  const auto map = std::make_shared<const LocalizationMap>("office-2", 7, MapContent{});
  answer.pose = LocalizedPose{.map = map, .T_map_base_link = {4.5, -0.75, 1.5}, .epoch = 3};
  AnswerHistory history;
  history.add(answer, 12, "t");
  const Json pose = render_history("s-1", history.answers())["answers"][0]["pose"];
  EXPECT_EQ(pose.dump(), Json::parse(R"({"map": "office-2", "revision": 7, "x": 4.5, "y": -0.75,
    "yaw": 1.5, "epoch": 3, "confirmed": false})")
                             .dump());
}

TEST(AnswerHistory, RecordsTheNewestAnswersWholeAndForgetsTheScansOfOlderOnes) {
  RobotScan scan;
  scan.scan.angle_increment = 0.5;
  scan.scan.range_max = 10.0;
  scan.scan.ranges = {2.0F};
  AnswerHistory history;
  for (std::uint64_t i = 0; i < 3; ++i) {
    history.add(collecting(Reason::kNoMotion), i, "t");
    history.record({.answer = R"({"sequence": 7, "hypotheses": []})",
                    .last_scan = scan,
                    .features_base_link = {{1.5, -0.5}}},
                   2);
  }
  const Json answers = render_history("s-1", history.answers())["answers"];
  ASSERT_EQ(answers.size(), 3U);
  EXPECT_FALSE(answers[0].contains("scan_points"));
  EXPECT_EQ(answers[0]["sequence"], 0);
  for (const std::size_t whole : {1U, 2U}) {
    EXPECT_EQ(answers[whole]["sequence"], 7) << "the rendered answer itself";
    EXPECT_EQ(answers[whole]["received"], "t");
    EXPECT_EQ(answers[whole]["scan_points"].dump(), "[[2.0,0.0]]");
    EXPECT_EQ(answers[whole]["feature_points"].dump(), "[[1.5,-0.5]]");
  }
}

}  // namespace
}  // namespace cornerfix::api
