#include "ros2/scan_assembler.hpp"

#include <gmock/gmock.h>

#include <numbers>

namespace cornerfix::ros2 {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

constexpr auto kStatic = FrameTree::Origin::kStatic;
constexpr auto kTf = FrameTree::Origin::kTf;

ReceivedScan scan_at(double stamp, double time_increment = 0.0) {
  LaserScan scan{stamp, -1.0, 0.5, 0.1, 10.0, {1.0F, 2.0F, 3.0F, 4.0F}};
  return {"laser", scan, time_increment};
}

StampedTransform transform(double stamp, const std::string& parent, const std::string& child,
                           double x, double roll = 0.0) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().x() = x;
  T.linear() = Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return {stamp, parent, child, T};
}

class ScanAssemblerTest : public ::testing::Test {
 protected:
  ScanAssemblerTest() { scans_.add_transform(transform(0, "base_link", "laser", 0.3), kStatic); }

  std::vector<AssembledScan> take(milliseconds after = milliseconds(0)) {
    return scans_.take_batch(now_ + after);
  }

  ScanAssembler::Clock::time_point now_ = {};
  ScanAssembler scans_{{}};
};

TEST_F(ScanAssemblerTest, WaitsForOdometryAfterTheStampAndInterpolates) {
  scans_.add_odometry(transform(1.0, "odom", "base_link", 1.0));
  scans_.add_scan(scan_at(1.5), now_);
  EXPECT_THAT(take(), IsEmpty());
  scans_.add_odometry(transform(2.0, "odom", "base_link", 2.0));
  const auto batch = take();
  ASSERT_THAT(batch, SizeIs(1));
  ASSERT_TRUE(batch[0].T_odom_base_link);
  EXPECT_NEAR(batch[0].T_odom_base_link->x, 1.5, 1e-9);
  EXPECT_NEAR(batch[0].T_base_link_laser.x, 0.3, 1e-9);
}

TEST_F(ScanAssemblerTest, TakesOdometryFromTf) {
  scans_.add_transform(transform(1.0, "robot/odom", "base_link", 1.0), kTf);
  scans_.add_scan(scan_at(1.0), now_);
  const auto batch = take();
  ASSERT_THAT(batch, SizeIs(1));
  EXPECT_NEAR(batch[0].T_odom_base_link->x, 1.0, 1e-9);
  EXPECT_EQ(scans_.odom_frame(), "robot/odom");
}

TEST_F(ScanAssemblerTest, LeavesOutOdometryThatDoesNotComeInTime) {
  scans_.add_scan(scan_at(1.0), now_);
  EXPECT_THAT(take(milliseconds(100)), IsEmpty());
  EXPECT_EQ(scans_.next_deadline(now_), now_ + milliseconds(250));
  const auto batch = take(milliseconds(250));
  ASSERT_THAT(batch, SizeIs(1));
  EXPECT_FALSE(batch[0].T_odom_base_link);
}

TEST_F(ScanAssemblerTest, NamesOdometryWithoutAPose) {
  scans_.add_scan(scan_at(1.0), now_);
  scans_.add_odometry(std::nullopt);
  const auto batch = take(milliseconds(250));
  ASSERT_THAT(batch, SizeIs(1));
  EXPECT_FALSE(batch[0].T_odom_base_link);
  EXPECT_THAT(scans_.problem(), HasSubstr("its orientation a unit quaternion"));
  scans_.add_odometry(transform(1.0, "odom", "base_link", 1.0));
  EXPECT_THAT(scans_.problem(), IsEmpty());
}

TEST_F(ScanAssemblerTest, NamesTheTransformThatIsMissing) {
  ReceivedScan scan = scan_at(1.0);
  scan.frame = "front_laser";
  scans_.add_scan(scan, now_);
  EXPECT_THAT(take(milliseconds(1000)), IsEmpty());
  EXPECT_EQ(scans_.problem(), "no transform from base_link to front_laser, the frame of the scans");
  scans_.add_transform(transform(0, "base_link", "front_laser", 0.5), kStatic);
  EXPECT_THAT(take(milliseconds(1000)), SizeIs(1));
  EXPECT_THAT(scans_.problem(), IsEmpty());
}

TEST_F(ScanAssemblerTest, TurnsTheBeamsOfALaserThatHangsUpsideDown) {
  scans_.add_transform(transform(0, "base_link", "laser", 0.3, std::numbers::pi), kStatic);
  scans_.add_scan(scan_at(1.0), now_);
  const auto batch = take(milliseconds(250));
  ASSERT_THAT(batch, SizeIs(1));
  EXPECT_EQ(batch[0].scan.angle_min, 1.0);
  EXPECT_EQ(batch[0].scan.angle_increment, -0.5);
}

TEST_F(ScanAssemblerTest, RefusesALaserThatLooksUp) {
  scans_.add_transform(transform(0, "base_link", "laser", 0.3, 1.0), kStatic);
  scans_.add_scan(scan_at(1.0), now_);
  EXPECT_THAT(take(milliseconds(250)), IsEmpty());
  EXPECT_THAT(scans_.problem(), HasSubstr("tilted by 1.0"));
}

TEST_F(ScanAssemblerTest, LeavesOutScansAboveTheRateAndThoseThatComeTwice) {
  for (const double stamp : {1.0, 1.025, 1.05, 1.095, 1.2, 1.2, 1.1}) {
    scans_.add_scan(scan_at(stamp), now_);
  }
  const auto batch = take(milliseconds(250));
  ASSERT_THAT(batch, SizeIs(3));
  EXPECT_EQ(batch[1].scan.stamp, 1.095);
  EXPECT_EQ(batch[2].scan.stamp, 1.2);
}

TEST_F(ScanAssemblerTest, BeginsARunWhenTheClockWasSetBack) {
  scans_.add_scan(scan_at(100.0), now_);
  scans_.add_scan(scan_at(1.0), now_);
  scans_.add_scan(scan_at(2.0), now_);
  const auto batch = take(milliseconds(250));
  ASSERT_THAT(batch, SizeIs(2));
  EXPECT_TRUE(batch[0].begins_run);
  EXPECT_EQ(batch[0].scan.stamp, 1.0);
  EXPECT_FALSE(batch[1].begins_run);
}

TEST_F(ScanAssemblerTest, PutsTwoScansInABatchWhenTheLidarMovesDuringAScan) {
  scans_.add_scan(scan_at(1.0, 0.001), now_);
  scans_.add_odometry(transform(1.0, "odom", "base_link", 1.0));
  EXPECT_THAT(take(), IsEmpty());
  scans_.add_scan(scan_at(2.0, 0.001), now_);
  scans_.add_odometry(transform(2.0, "odom", "base_link", 2.0));
  EXPECT_THAT(take(), SizeIs(2));
}

TEST_F(ScanAssemblerTest, KeepsTheNewestScansWhileTheServerDoesNotAnswer) {
  for (int i = 0; i < 200; ++i) scans_.add_scan(scan_at(i), now_);
  double last = 0.0;
  std::size_t count = 0;
  for (auto batch = take(milliseconds(250)); !batch.empty(); batch = take(milliseconds(250))) {
    EXPECT_LE(batch.size(), 20U);
    count += batch.size();
    last = batch.back().scan.stamp;
  }
  EXPECT_EQ(count, 50U);
  EXPECT_EQ(last, 199.0);
}

/// Two lidars, whose odometry comes before their scans.
class TwoLidarsTest : public ScanAssemblerTest {
 protected:
  TwoLidarsTest() {
    scans_ = ScanAssembler({.lidars = {"front", "rear"}});
    scans_.add_transform(transform(0, "base_link", "laser", 0.3), kStatic);
    scans_.add_transform(transform(0, "base_link", "rear_laser", -0.3), kStatic);
    add_odometry();
  }

  /// Of a robot that stands, for all stamps from 0 to 20.
  void add_odometry() {
    for (const double stamp : {0.0, 20.0})
      scans_.add_odometry(transform(stamp, "odom", "base_link", 1.0));
  }

  void add(std::size_t lidar, double stamp, milliseconds after = milliseconds(0),
           double time_increment = 0.0) {
    ReceivedScan scan = scan_at(stamp, time_increment);
    if (lidar == 1) scan.frame = "rear_laser";
    scans_.add_scan(std::move(scan), now_ + after, lidar);
  }
};

std::vector<std::pair<std::string, double>> taken(const std::vector<AssembledScan>& batch) {
  std::vector<std::pair<std::string, double>> out;
  for (const AssembledScan& scan : batch) out.emplace_back(scan.lidar, scan.scan.stamp);
  return out;
}

TEST_F(TwoLidarsTest, AreSentInTheOrderOfTheirStamps) {
  add(0, 1.0);
  add(1, 1.05);
  EXPECT_THAT(taken(take()), ElementsAre(Pair("front", 1.0)));
  add(1, 1.15);
  EXPECT_THAT(take(), IsEmpty()) << "a scan of the front lidar at 1.1 is to be expected";
  add(0, 1.1);
  const auto batch = take();
  EXPECT_THAT(taken(batch), ElementsAre(Pair("rear", 1.05), Pair("front", 1.1)));
  EXPECT_NEAR(batch[0].T_base_link_laser.x, -0.3, 1e-9);
  EXPECT_NEAR(batch[1].T_base_link_laser.x, 0.3, 1e-9);
}

TEST_F(TwoLidarsTest, MayHaveEqualStamps) {
  add(0, 1.0);
  add(1, 1.0);
  EXPECT_THAT(taken(take()), ElementsAre(Pair("front", 1.0), Pair("rear", 1.0)));
  EXPECT_THAT(scans_.problem(), IsEmpty());
}

TEST_F(TwoLidarsTest, DoNotWaitLongForOneThatIsLate) {
  add(0, 1.0);
  add(1, 1.0);
  ASSERT_THAT(take(), SizeIs(2));
  add(0, 1.2);
  EXPECT_THAT(take(milliseconds(100)), IsEmpty());
  EXPECT_EQ(scans_.next_deadline(now_ + milliseconds(100)), now_ + milliseconds(250));
  EXPECT_THAT(taken(take(milliseconds(250))), ElementsAre(Pair("front", 1.2)));
  add(1, 1.1, milliseconds(260));
  EXPECT_THAT(take(milliseconds(260)), IsEmpty());
  EXPECT_THAT(scans_.problem(), HasSubstr("rear: scans come later than those of the other lidars"));
}

TEST_F(TwoLidarsTest, DoNotWaitForOneThatIsSilentAndNameIt) {
  add(0, 1.0);
  EXPECT_THAT(take(), SizeIs(1)) << "the rear lidar was never heard";
  EXPECT_EQ(scans_.problem(), "rear: no scans");
  add(1, 1.1);
  add(0, 1.2);
  ASSERT_THAT(take(), SizeIs(1));
  EXPECT_THAT(scans_.problem(), IsEmpty());
  add(0, 3.0);
  EXPECT_THAT(taken(take()), ElementsAre(Pair("front", 1.2), Pair("front", 3.0)));
  EXPECT_EQ(scans_.problem(), "rear: no scans");
}

TEST_F(TwoLidarsTest, WorkWhileOneHasNoTransform) {
  scans_ = ScanAssembler({.lidars = {"front", "rear"}});
  add_odometry();
  scans_.add_transform(transform(0, "base_link", "laser", 0.3), kStatic);
  add(0, 1.0);
  add(1, 1.0);
  EXPECT_THAT(taken(take(milliseconds(250))), ElementsAre(Pair("front", 1.0)));
  EXPECT_EQ(scans_.problem(),
            "rear: no transform from base_link to rear_laser, the frame of the scans");
}

TEST_F(TwoLidarsTest, SendTwoScansOfEachWhenTheyMoveDuringAScan) {
  for (const std::size_t lidar : {0U, 1U}) add(lidar, 1.0, milliseconds(0), 0.001);
  EXPECT_THAT(take(), IsEmpty());
  add(0, 1.1, milliseconds(0), 0.001);
  EXPECT_THAT(take(), IsEmpty());
  add(1, 1.1, milliseconds(0), 0.001);
  EXPECT_THAT(take(), SizeIs(4));
}

TEST_F(TwoLidarsTest, BeginARunTogetherWhenTheClockWasSetBack) {
  add(0, 10.0);
  add(1, 10.0);
  ASSERT_THAT(take(), SizeIs(2));
  add(0, 1.0);
  add(1, 1.0);
  add(0, 1.2);
  add(1, 1.2);
  const auto batch = take();
  ASSERT_THAT(batch, SizeIs(4));
  EXPECT_TRUE(batch[0].begins_run);
  for (std::size_t i = 1; i < batch.size(); ++i) EXPECT_FALSE(batch[i].begins_run);
}

}  // namespace
}  // namespace cornerfix::ros2
