#include "ros2/pose_gate.hpp"

#include <gtest/gtest.h>

namespace cornerfix::ros2 {
namespace {

Answer localized(std::uint64_t epoch, bool is_confirmed = false) {
  Answer answer{"session", "localized", "", 0.99, LocalizedPose{}};
  answer.pose->epoch = epoch;
  answer.pose->is_confirmed = is_confirmed;
  return answer;
}

Answer without_pose(const std::string& status) {
  return {"session", status, "few_features", 0.2, std::nullopt};
}

TEST(PoseGate, NeverPassesAnAnswerWithoutAPose) {
  PoseGate gate(PublishWhen::kLocalized);
  for (const char* status : {"collecting", "ambiguous", "lost"}) {
    EXPECT_FALSE(gate.pass(without_pose(status), true)) << status;
    EXPECT_FALSE(gate.is_open(without_pose(status))) << status;
  }
}

TEST(PoseGate, PassesOncePerEpoch) {
  PoseGate gate(PublishWhen::kLocalized);
  EXPECT_TRUE(gate.pass(localized(1), true));
  EXPECT_FALSE(gate.pass(localized(1), true));
  EXPECT_FALSE(gate.pass(without_pose("lost"), true));
  EXPECT_FALSE(gate.pass(localized(1), true));
  EXPECT_TRUE(gate.pass(localized(2), true));
}

TEST(PoseGate, PassesTheSameEpochOfAnotherSession) {
  PoseGate gate(PublishWhen::kLocalized);
  EXPECT_TRUE(gate.pass(localized(1), true));
  Answer other = localized(1);
  other.session = "another";
  EXPECT_TRUE(gate.pass(other, true));
}

TEST(PoseGate, WaitsForConfirmation) {
  PoseGate gate(PublishWhen::kConfirmed);
  EXPECT_FALSE(gate.is_open(localized(1)));
  EXPECT_FALSE(gate.pass(localized(1), true));
  EXPECT_TRUE(gate.pass(localized(1, true), true));
  EXPECT_FALSE(gate.pass(localized(1, true), true));
}

TEST(PoseGate, WaitsForASubscriberAndPassesAgainForTheNextOne) {
  PoseGate gate(PublishWhen::kLocalized);
  EXPECT_FALSE(gate.pass(localized(1), false));
  EXPECT_TRUE(gate.pass(localized(1), true));
  EXPECT_FALSE(gate.pass(localized(1), true));
  EXPECT_FALSE(gate.pass(localized(1), false)) << "the subscriber was switched off";
  EXPECT_TRUE(gate.pass(localized(1), true));
}

}  // namespace
}  // namespace cornerfix::ros2
