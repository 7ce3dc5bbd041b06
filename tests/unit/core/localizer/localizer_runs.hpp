/// \file  Runs in random rooms, and how the answers to them are judged.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/localizer.hpp>

#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"
#include "support/matchers.hpp"
#include "support/simulated_drive.hpp"

namespace cornerfix::localizer_tests {

using testing::drive;
using testing::IsPoseNear;
using testing::Moment;
using testing::Robot;
using testing::SceneBuilder;

inline constexpr double kPi = std::numbers::pi;
/// Of the room of tests that need only one.
inline constexpr std::uint64_t kRoomSeed = 14;
inline constexpr double kRightMetres = 0.15;
inline constexpr double kRightRadians = 0.03;
inline constexpr Method kMethods[] = {Method::kRma, Method::kNma, Method::kIndexed};

inline LocalizerParams with(Method method) {
  LocalizerParams params;
  params.method = method;
  return params;
}

/// All methods in turn.
inline Method method_for(std::uint64_t seed) { return kMethods[seed % std::size(kMethods)]; }

inline LocalizationMapPtr room_map(std::uint64_t seed) {
  return testing::make_map(testing::random_room(seed), {0.0, 0.0});
}

/// A run about the middle of random_room(seed) from a pose that `seed` draws.
inline std::vector<Moment> room_drive(std::uint64_t seed, std::size_t count,
                                      const Robot& robot = {}) {
  const SceneBuilder room = testing::random_room(seed);
  std::mt19937_64 random(seed + 1000);
  std::uniform_real_distribution<double> position(-0.8, 0.8), yaw(-kPi, kPi);
  const Pose2 start{position(random), position(random), yaw(random)};
  return drive(room, robot, testing::wander(room, start, count), seed);
}

inline std::vector<Answer> answers_of(Localizer& localizer, const std::vector<Moment>& moments) {
  std::vector<Answer> answers;
  for (const Moment& moment : moments) {
    answers.push_back(localizer.process(moment.scan));
    const Answer& answer = answers.back();
    EXPECT_EQ(answer.pose.has_value(), answer.status == Status::kLocalized);
    EXPECT_GE(answer.confidence, 0.0);
    EXPECT_LE(answer.confidence, 1.0);
  }
  return answers;
}

inline std::vector<Answer> answers_of(std::vector<LocalizationMapPtr> maps,
                                      const LocalizerParams& params,
                                      const std::vector<Moment>& moments) {
  Localizer localizer(std::move(maps), params);
  return answers_of(localizer, moments);
}

inline std::size_t count(const std::vector<Answer>& answers, Status status) {
  return static_cast<std::size_t>(std::ranges::count(answers, status, &Answer::status));
}

/// Answers that give a pose that is not the true one.
inline std::size_t count_wrong(const std::vector<Answer>& answers,
                               const std::vector<Moment>& moments, double metres = 0.3,
                               double radians = 0.1) {
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!answers[i].pose) continue;
    const Pose2& pose = answers[i].pose->T_map_base_link;
    const bool right = distance(pose, moments[i].T_map_base_link) <= metres &&
                       angle_between(pose, moments[i].T_map_base_link) <= radians;
    wrong += right ? 0 : 1;
  }
  return wrong;
}

inline void expect_localized_at(const Answer& answer, const Pose2& truth) {
  ASSERT_EQ(answer.status, Status::kLocalized) << to_string(answer.reason);
  EXPECT_THAT(answer.pose->T_map_base_link, IsPoseNear(truth, kRightMetres, kRightRadians));
}

/// All that can be compared of two answers but times.
inline void expect_same(const Answer& actual, const Answer& expected) {
  EXPECT_EQ(to_string(actual.status), to_string(expected.status));
  EXPECT_EQ(to_string(actual.reason), to_string(expected.reason));
  EXPECT_EQ(actual.confidence, expected.confidence);
  EXPECT_EQ(actual.local_scans, expected.local_scans);
  EXPECT_EQ(actual.local_features, expected.local_features);
  EXPECT_EQ(actual.T_submap_base_link, expected.T_submap_base_link);
  ASSERT_EQ(actual.pose.has_value(), expected.pose.has_value());
  if (actual.pose) {
    EXPECT_EQ(actual.pose->T_map_base_link, expected.pose->T_map_base_link);
    EXPECT_EQ(actual.pose->covariance, expected.pose->covariance);
  }
  ASSERT_EQ(actual.hypotheses.size(), expected.hypotheses.size());
  for (std::size_t i = 0; i < actual.hypotheses.size(); ++i) {
    EXPECT_EQ(actual.hypotheses[i].T_map_base_link, expected.hypotheses[i].T_map_base_link);
    EXPECT_EQ(actual.hypotheses[i].score, expected.hypotheses[i].score);
  }
}

/// The same up to what is made anew after a restart: hypotheses, and the field that scans are
/// matched on, which no longer shows the walls of forgotten scans.
inline void expect_alike(const Answer& actual, const Answer& expected) {
  EXPECT_EQ(to_string(actual.status), to_string(expected.status));
  EXPECT_EQ(to_string(actual.reason), to_string(expected.reason));
  EXPECT_NEAR(actual.confidence, expected.confidence, 0.05);
  EXPECT_EQ(actual.local_scans, expected.local_scans);
  EXPECT_THAT(actual.T_submap_base_link, IsPoseNear(expected.T_submap_base_link, 0.01, 0.005));
  ASSERT_EQ(actual.pose.has_value(), expected.pose.has_value());
  if (!actual.pose) return;
  EXPECT_THAT(actual.pose->T_map_base_link,
              IsPoseNear(expected.pose->T_map_base_link, 0.02, 0.005));
}

inline SceneBuilder mirrored(const SceneBuilder& scene) {
  SceneBuilder result;
  for (const testing::Wall& wall : scene.walls()) {
    result.wall({wall.a.x(), -wall.a.y()}, {wall.b.x(), -wall.b.y()});
  }
  return result;
}

/// Drives until a few scans after it is first localized.
inline std::vector<Answer> answers_until_fixed(Localizer& localizer,
                                               const std::vector<Moment>& moments) {
  std::vector<Answer> answers;
  for (const Moment& moment : moments) {
    answers.push_back(answers_of(localizer, {moment}).front());
    if (count(answers, Status::kLocalized) > 3) break;
  }
  return answers;
}

}  // namespace cornerfix::localizer_tests
