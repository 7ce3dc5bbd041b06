#include "api/answer_profiles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace cornerfix::api {
namespace {

Json plain_answer() {
  return Json::parse(R"({
    "session": "s", "sequence": 12, "status": "localized",
    "pose": {"map": "office-2", "revision": 7, "stamp": 1284.25, "x": 4.0, "y": -1.0, "yaw": 2.0,
             "covariance": [0.04, 0.0, 0.001, 0.0, 0.01, 0.002, 0.001, 0.002, 0.003],
             "epoch": 3, "confirmed": true},
    "confidence": 0.998,
    "hypotheses": [{"map": "office-2", "revision": 7, "x": 4.0, "y": -1.0, "yaw": 2.0, "votes": 1,
                    "inliers": 2, "score": 0.9}],
    "given": null, "reason": null, "odometry": "used",
    "local": {"scans": 40, "features": 23, "pose": {"x": 1.0, "y": 2.0, "yaw": 0.0}}})");
}

Json lost_answer() {
  Json answer = plain_answer();
  answer["status"] = "lost";
  answer["pose"] = nullptr;
  answer["reason"] = "contradicted";
  return answer;
}

Json session_with(const Json& answer, bool is_stale = false) {
  const Json status = answer.is_null() ? Json("collecting") : answer["status"];
  return {{"id", "s"}, {"status", status}, {"stale", is_stale}, {"last_answer", answer}};
}

TEST(AnswerProfiles, HaveNames) {
  for (const AnswerProfile profile : {AnswerProfile::kRos, AnswerProfile::kVda5050})
    EXPECT_EQ(answer_profile_from_string(to_string(profile)), profile);
  EXPECT_FALSE(answer_profile_from_string("").has_value());
}

TEST(AnswerProfiles, PlainIsTheAnswer) {
  EXPECT_EQ(in_profile(plain_answer(), AnswerProfile::kPlain), plain_answer());
}

TEST(AnswerProfiles, ForRosThePoseIsAStampedPoseWithCovariance) {
  const Json answer = in_profile(plain_answer(), AnswerProfile::kRos);
  const Json& pose = answer["pose"];
  EXPECT_EQ(pose["header"]["frame_id"], "map");
  EXPECT_EQ(pose["header"]["stamp"], (Json{{"sec", 1284}, {"nanosec", 250'000'000}}));
  EXPECT_EQ(pose["pose"]["pose"]["position"], (Json{{"x", 4.0}, {"y", -1.0}, {"z", 0.0}}));
  EXPECT_DOUBLE_EQ(pose["pose"]["pose"]["orientation"]["z"], std::sin(1.0));
  EXPECT_DOUBLE_EQ(pose["pose"]["pose"]["orientation"]["w"], std::cos(1.0));
  const Json& covariance = pose["pose"]["covariance"];
  ASSERT_EQ(covariance.size(), 36U);
  EXPECT_EQ(covariance[0], 0.04);
  EXPECT_EQ(covariance[7], 0.01);
  EXPECT_EQ(covariance[5], 0.001);
  EXPECT_EQ(covariance[31], 0.002);
  EXPECT_EQ(covariance[35], 0.003);
  EXPECT_EQ(covariance[14], 0.0);
  EXPECT_EQ(answer["localized"],
            (Json{{"map", "office-2"}, {"revision", 7}, {"epoch", 3}, {"confirmed", true}}));
  EXPECT_EQ(answer["hypotheses"][0]["pose"]["position"]["x"], 4.0);
  EXPECT_EQ(answer["hypotheses"][0]["votes"], 1);
  EXPECT_EQ(answer["local"]["pose"]["orientation"]["w"], 1.0);
  EXPECT_EQ(answer["status"], "localized");
}

TEST(AnswerProfiles, ForRosThereIsNoPoseUnlessLocalized) {
  const Json answer = in_profile(lost_answer(), AnswerProfile::kRos);
  EXPECT_TRUE(answer["pose"].is_null());
  EXPECT_TRUE(answer["localized"].is_null());
}

TEST(AnswerProfiles, RosStampsHaveTheirNanosecondsInASecond) {
  Json answer = plain_answer();
  answer["pose"]["stamp"] = -0.25;
  EXPECT_EQ(in_profile(answer, AnswerProfile::kRos)["pose"]["header"]["stamp"],
            (Json{{"sec", -1}, {"nanosec", 750'000'000}}));
  answer["pose"]["stamp"] = 0.9999999999;
  EXPECT_EQ(in_profile(answer, AnswerProfile::kRos)["pose"]["header"]["stamp"],
            (Json{{"sec", 1}, {"nanosec", 0}}));
}

TEST(AnswerProfiles, ForVda5050ALocalizedRobotHasAPositionAndNoError) {
  const Json state = in_profile(plain_answer(), AnswerProfile::kVda5050);
  const Json& position = state["agvPosition"];
  EXPECT_EQ(position["x"], 4.0);
  EXPECT_EQ(position["y"], -1.0);
  EXPECT_EQ(position["theta"], 2.0);
  EXPECT_EQ(position["mapId"], "office-2");
  EXPECT_EQ(position["localized"], true);
  EXPECT_EQ(position["positionInitialized"], true);
  EXPECT_EQ(position["localizationScore"], 0.998);
  EXPECT_DOUBLE_EQ(position["deviationRange"], 0.2);
  EXPECT_EQ(state["maps"][0],
            (Json{{"mapId", "office-2"}, {"mapVersion", "7"}, {"mapStatus", "ENABLED"}}));
  EXPECT_TRUE(state["errors"].empty());
}

TEST(AnswerProfiles, ForVda5050ARobotThatIsNotLocalizedHasAnError) {
  const Json state = in_profile(lost_answer(), AnswerProfile::kVda5050);
  EXPECT_FALSE(state.contains("agvPosition"));
  ASSERT_EQ(state["errors"].size(), 1U);
  const Json& error = state["errors"][0];
  EXPECT_EQ(error["errorType"], "LOCALIZATION_ERROR");
  EXPECT_EQ(error["errorLevel"], "CRITICAL");
  EXPECT_EQ(error["errorReferences"],
            Json::parse(R"([{"referenceKey": "status", "referenceValue": "lost"},
                            {"referenceKey": "reason", "referenceValue": "contradicted"}])"));
  Json answer = lost_answer();
  answer["status"] = "ambiguous";
  EXPECT_EQ(in_profile(answer, AnswerProfile::kVda5050)["errors"][0]["errorLevel"], "WARNING");
}

TEST(AnswerProfiles, ForVda5050TheOldPositionOfASilentRobotIsNotLocalized) {
  const Json state =
      session_in_profile(session_with(plain_answer(), true), AnswerProfile::kVda5050);
  EXPECT_EQ(state["agvPosition"]["localized"], false);
  EXPECT_EQ(state["errors"][0]["errorLevel"], "CRITICAL");
  EXPECT_TRUE(
      session_in_profile(session_with(plain_answer()), AnswerProfile::kVda5050)["errors"].empty());
}

TEST(AnswerProfiles, ASessionWithoutAnswerHasNoPose) {
  const Json session = session_with(nullptr);
  EXPECT_EQ(session_in_profile(session, AnswerProfile::kRos), session);
  const Json state = session_in_profile(session, AnswerProfile::kVda5050);
  EXPECT_FALSE(state.contains("agvPosition"));
  EXPECT_EQ(state["errors"][0]["errorReferences"].size(), 1U);
}

TEST(AnswerProfiles, ForRosTheLastAnswerOfASessionIsInIt) {
  const Json session = session_in_profile(session_with(plain_answer()), AnswerProfile::kRos);
  EXPECT_EQ(session["id"], "s");
  EXPECT_EQ(session["last_answer"], in_profile(plain_answer(), AnswerProfile::kRos));
}

}  // namespace
}  // namespace cornerfix::api
