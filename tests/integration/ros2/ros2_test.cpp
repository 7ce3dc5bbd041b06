// `cornerfix ros2` as a program, between a real server and robots that speak DDS by another
// implementation, Fast DDS.
#include <gmock/gmock.h>

#include <cmath>

#include "integration/ros2/ros2_robot.hpp"
#include "integration/test_server.hpp"
#include "support/program.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::planar;
using testing::Ros2Robot;
using ::testing::SizeIs;

constexpr double kMaxErrorM = 0.1;
constexpr double kMaxErrorRad = 0.05;

class Ros2Test : public ::testing::Test {
 protected:
  Ros2Test() : server_(directory_ / "test.db"), http_(server_.port()) {
    testing::make_room_map(http_, "office");
  }

  std::vector<std::string> environment() const {
    return {"ROS_DOMAIN_ID=" + std::to_string(domain_.id()), "ROS_LOCALHOST_ONLY=1",
            "CYCLONEDDS_URI="};
  }
  std::vector<std::string> arguments(const std::vector<std::string>& more) const {
    std::vector<std::string> all = {"ros2", "--server",
                                    "http://127.0.0.1:" + std::to_string(server_.port())};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// `cornerfix ros2` with these options.
  std::unique_ptr<testing::Program> start(const std::vector<std::string>& more) const {
    return std::make_unique<testing::Program>(CORNERFIX_PROGRAM, arguments(more), environment());
  }

  /// Scan by scan until the client has reported an answer with this status, 40 scans at most.
  static void drive_until(Ros2Robot& robot, const std::string& status) {
    for (int i = 0; i < 40 && robot.status() != status; ++i) robot.drive(1);
    ASSERT_EQ(robot.status(), status);
  }

  static void expect_true_pose(const Ros2Robot& robot,
                               const testing::ros::PoseWithCovarianceStamped& message) {
    const Pose2 pose = planar(message.pose);
    const Pose2 truth = robot.truth(message.header).T_map_base_link;
    EXPECT_LT(distance(pose, truth), kMaxErrorM);
    EXPECT_LT(angle_between(pose, truth), kMaxErrorRad);
    EXPECT_EQ(message.header.frame_id, "map");
    for (const std::size_t variance : {0U, 7U, 35U}) EXPECT_GT(message.covariance[variance], 0.0);
    for (const std::size_t of_z : {14U, 21U, 28U}) EXPECT_EQ(message.covariance[of_z], 0.0);
  }

  testing::TemporaryDirectory directory_;
  testing::FreeDomain domain_;
  testing::TestServer server_;
  testing::HttpClient http_;
};

TEST_F(Ros2Test, PublishesThePoseOnceAndOnlyWhenTheServerHasLocalizedTheRobot) {
  Ros2Robot robot(domain_.id(), {});
  const auto client = start({"--map", "office"});
  ASSERT_TRUE(robot.wait_for_client());
  robot.cover_lidar(true);
  robot.drive(5);
  EXPECT_EQ(robot.status(), "collecting");
  EXPECT_THAT(robot.poses, IsEmpty());
  robot.cover_lidar(false);
  drive_until(robot, "localized");
  ASSERT_TRUE(robot.wait_until([&] { return !robot.poses.empty(); }));
  expect_true_pose(robot, robot.poses.front());
  robot.drive(5);
  EXPECT_EQ(robot.status(), "localized");
  EXPECT_THAT(robot.poses, SizeIs(1)) << "the epoch is the same";
}

TEST_F(Ros2Test, ReportsStatusReasonEpochAndConfidence) {
  Ros2Robot robot(domain_.id(), {});
  const auto client = start({});
  ASSERT_TRUE(robot.wait_for_client());
  robot.cover_lidar(true);
  robot.drive(1);
  const testing::ros::DiagnosticStatus first = robot.diagnoses.back();
  EXPECT_EQ(first.level, 1) << "WARN, not: " << first.message;
  EXPECT_EQ(first.value("status"), "collecting");
  EXPECT_EQ(first.value("reason"), "no_returns");
  EXPECT_EQ(first.value("epoch"), "");
  robot.cover_lidar(false);
  drive_until(robot, "localized");
  const testing::ros::DiagnosticStatus last = robot.diagnoses.back();
  EXPECT_EQ(last.level, 0) << "OK";
  EXPECT_EQ(last.name, "cornerfix: robot");
  EXPECT_EQ(last.value("epoch"), "1");
  EXPECT_GT(std::stod(last.value("confidence")), 0.9);
  EXPECT_EQ(last.value("map"), "office");
}

TEST_F(Ros2Test, TakesOdometryOfTfAndALaserThatHangsUpsideDown) {
  Ros2Robot robot(domain_.id(), {.ns = "",
                                 .prefix = "",
                                 .scan_qos = testing::kReliableQos,
                                 .has_odometry_in_tf = true,
                                 .is_upside_down = true});
  const auto client = start({"--map", "office"});
  ASSERT_TRUE(robot.wait_for_client());
  drive_until(robot, "localized");
  ASSERT_TRUE(robot.wait_until([&] { return !robot.poses.empty(); }));
  expect_true_pose(robot, robot.poses.front());
  const testing::Json sessions = http_.get("/v1/sessions").json()["sessions"];
  EXPECT_EQ(sessions.at(0)["last_answer"]["odometry"], "used");
}

TEST_F(Ros2Test, JoinsTheScansOfTwoLidars) {
  Ros2Robot robot(domain_.id(), {.ns = "", .prefix = "", .has_rear_lidar = true});
  const auto client = start({"--map", "office", "--scan", "scan", "--scan", "rear/scan"});
  ASSERT_TRUE(robot.wait_for_client());
  drive_until(robot, "localized");
  ASSERT_TRUE(robot.wait_until([&] { return !robot.poses.empty(); }));
  expect_true_pose(robot, robot.poses.front());
  const testing::Json session = http_.get("/v1/sessions").json()["sessions"].at(0);
  EXPECT_TRUE(session["lidars"].contains("scan"));
  EXPECT_TRUE(session["lidars"].contains("rear.scan"));
}

TEST_F(Ros2Test, SearchesOnlyWhereTheRobotIsSwitchedOn) {
  Ros2Robot robot(domain_.id(), {});
  const auto client = start({"--map", "office", "--near", "5", "5", "2.5"});
  ASSERT_TRUE(robot.wait_for_client());
  drive_until(robot, "localized");
  const testing::Json session = http_.get("/v1/sessions").json()["sessions"].at(0);
  EXPECT_EQ(session["near"]["radius_m"], 2.5);
  EXPECT_EQ(session["last_answer"]["given"], "near");
}

TEST_F(Ros2Test, MatchesAnOdometryPublisherOfBestEffort) {
  Ros2Robot robot(domain_.id(), {.ns = "", .prefix = "", .odom_qos = testing::kSensorQos});
  const auto client = start({});
  EXPECT_TRUE(robot.wait_for_client());
}

TEST_F(Ros2Test, PublishesTheTransformFromMapToOdomWithEveryPose) {
  Ros2Robot robot(domain_.id(), {});
  const auto client = start({"--tf"});
  ASSERT_TRUE(robot.wait_for_client());
  drive_until(robot, "localized");
  robot.drive(3);
  ASSERT_TRUE(robot.wait_until([&] { return robot.transforms.size() == 4; }));
  auto transform = robot.transforms.back();
  EXPECT_EQ(transform.header.frame_id, "map");
  transform.header.sec -= 1;  // It is dated ahead by as long as it may be used.
  const Ros2Robot::TruePose truth = robot.truth(transform.header);
  const Pose2 T_map_base_link = planar(transform.transform) * truth.T_odom_base_link;
  EXPECT_LT(distance(T_map_base_link, truth.T_map_base_link), kMaxErrorM);
}

TEST_F(Ros2Test, WaitsForConfirmationWhereItIsAskedTo) {
  Ros2Robot robot(domain_.id(), {});
  const auto client = start({"--when", "confirmed"});
  ASSERT_TRUE(robot.wait_for_client());
  drive_until(robot, "localized");
  const auto is_confirmed = [&] { return robot.diagnoses.back().value("confirmed") == "true"; };
  EXPECT_FALSE(is_confirmed());
  for (int i = 0; i < 60 && !is_confirmed(); ++i) {
    EXPECT_THAT(robot.poses, IsEmpty());
    robot.drive(1);
  }
  ASSERT_TRUE(is_confirmed());
  ASSERT_TRUE(robot.wait_until([&] { return !robot.poses.empty(); }));
  expect_true_pose(robot, robot.poses.front());
}

TEST_F(Ros2Test, PublishesAgainAfterTheClockWasSetBack) {
  Ros2Robot robot(domain_.id(), {});
  const auto client = start({});
  ASSERT_TRUE(robot.wait_for_client());
  drive_until(robot, "localized");
  ASSERT_TRUE(robot.wait_until([&] { return robot.poses.size() == 1; }));
  robot.restart_clock();
  robot.drive(1);
  drive_until(robot, "localized");
  ASSERT_TRUE(robot.wait_until([&] { return robot.poses.size() == 2; }));
  expect_true_pose(robot, robot.poses.back());
}

TEST_F(Ros2Test, ServesSeveralRobotsInOneProcess) {
  Ros2Robot one(domain_.id(), {.ns = "/one", .prefix = "one/", .begin_rad = 2.0});
  Ros2Robot two(domain_.id(), {.ns = "/two", .prefix = "two/", .begin_rad = 4.5});
  const auto client = start({"--robot", "one=one", "--robot", "two=/two"});
  ASSERT_TRUE(one.wait_for_client());
  ASSERT_TRUE(two.wait_for_client());
  for (Ros2Robot* robot : {&one, &two}) {
    drive_until(*robot, "localized");
    ASSERT_TRUE(robot->wait_until([&] { return !robot->poses.empty(); }));
    expect_true_pose(*robot, robot->poses.front());
  }
}

TEST_F(Ros2Test, DeletesItsSessionAtSigterm) {
  Ros2Robot robot(domain_.id(), {});
  const auto client = start({});
  ASSERT_TRUE(robot.wait_for_client());
  robot.drive(1);
  ASSERT_THAT(http_.get("/v1/sessions").json()["sessions"], SizeIs(1));
  client->signal(SIGTERM);
  EXPECT_EQ(client->wait(), 0);
  EXPECT_THAT(client->rest_of_output(), HasSubstr("robot: waiting for scans on /scan\n"));
  EXPECT_THAT(http_.get("/v1/sessions").json()["sessions"], IsEmpty());
}

TEST_F(Ros2Test, EndsAtOnceWhenTheMapDoesNotExist) {
  const auto client = start({"--map", "offce"});
  EXPECT_EQ(client->wait(), 1);
}

TEST_F(Ros2Test, RefusesRobotsThatShareTheirTopics) {
  EXPECT_EQ(start({"--robot", "one", "--robot", "two"})->wait(), 2);
  EXPECT_EQ(start({"--robot", "one=a", "--robot", "one=b"})->wait(), 2);
  EXPECT_EQ(start({"--scan", "scan", "--scan", "/scan"})->wait(), 2);
  EXPECT_EQ(start({"--remap", "scam:=front/scan"})->wait(), 2);
}

}  // namespace
}  // namespace cornerfix
