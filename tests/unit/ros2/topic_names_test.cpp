#include "ros2/topic_names.hpp"

#include <gtest/gtest.h>

namespace cornerfix::ros2 {
namespace {

TEST(TopicNames, AreThoseOfRosInTheNamespaceOfTheRobot) {
  const Remappings none;
  EXPECT_EQ(none.resolve("scan", ""), "/scan");
  EXPECT_EQ(none.resolve("scan", "robot1"), "/robot1/scan");
  EXPECT_EQ(none.resolve("initialpose", "/fleet/robot1"), "/fleet/robot1/initialpose");
}

TEST(TopicNames, OfTfAndDiagnosticsAreInNoNamespace) {
  const Remappings none;
  EXPECT_EQ(none.resolve("tf", "robot1"), "/tf");
  EXPECT_EQ(none.resolve("tf_static", "robot1"), "/tf_static");
  EXPECT_EQ(none.resolve("diagnostics", "robot1"), "/diagnostics");
}

TEST(TopicNames, AreRemapped) {
  Remappings remappings;
  ASSERT_TRUE(remappings.add("scan:=front/scan"));
  ASSERT_TRUE(remappings.add("tf:=tf"));
  ASSERT_TRUE(remappings.add("odom:=/odometry/filtered"));
  EXPECT_EQ(remappings.resolve("scan", "robot1"), "/robot1/front/scan");
  EXPECT_EQ(remappings.resolve("tf", "robot1"), "/robot1/tf");
  EXPECT_EQ(remappings.resolve("odom", "robot1"), "/odometry/filtered");
}

TEST(TopicNames, RefusesRemappingsThatCannotBeMeant) {
  Remappings remappings;
  for (const char* wrong : {"scan", "scan=front", "scam:=front", "scan:=", "scan:=front scan",
                            "scan:=2d/scan", "scan:=front//scan", "scan:=front/"}) {
    EXPECT_FALSE(remappings.add(wrong)) << wrong;
  }
}

TEST(TopicNames, OfFurtherLidarsAreInTheNamespaceToo) {
  EXPECT_EQ(Remappings{}.resolve("rear/scan", "robot1"), "/robot1/rear/scan");
  EXPECT_EQ(Remappings{}.resolve("/rear/scan", "robot1"), "/rear/scan");
}

TEST(TopicNames, NameALidarOnTheServer) {
  EXPECT_EQ(lidar_name("/robot1/rear/scan"), "robot1.rear.scan");
  EXPECT_EQ(lidar_name("/_scan"), "scan");
}

TEST(TopicNames, AreMangledAsByTheMiddlewareOfRos) {
  EXPECT_EQ(dds_topic("/robot1/scan"), "rt/robot1/scan");
}

}  // namespace
}  // namespace cornerfix::ros2
