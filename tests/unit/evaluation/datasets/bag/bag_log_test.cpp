// Bags of all kinds through the door that the commands use.
#include "unit/evaluation/datasets/bag/bag_reading.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace cornerfix::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST_F(BagReading, ReadsRos1BagsOfEachCompression) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    const auto path = directory_.write("drive.bag", ros1_bag(drive(kRos1, 20), compression));
    const RecordedLog log = read(path);
    EXPECT_EQ(log.header.name, "drive");
    expect_drive(log, 20);
    EXPECT_EQ(remarks_, "");
  }
}

TEST_F(BagReading, ReadsMcapOfEachCompression) {
  for (const char* compression : {"", "lz4", "zstd"}) {
    SCOPED_TRACE(compression);
    expect_drive(read(directory_.write("drive.mcap", mcap(drive(kCdr, 20), compression))), 20);
    EXPECT_EQ(remarks_, "");
  }
}

TEST_F(BagReading, ReadsTheDatabaseOfARos2Bag) {
  std::vector<WrittenMessage> messages;
  for (const auto& chunk : drive(kCdr, 20)) {
    messages.insert(messages.end(), chunk.begin(), chunk.end());
  }
  const auto path = directory_.path() / "drive_0.db3";
  write_sqlite_bag(path, messages);
  expect_drive(read(path), 20);
  EXPECT_EQ(remarks_, "");
}

TEST_F(BagReading, DetectsBagsByTheirFirstBytes) {
  expect_drive(read(directory_.write("drive", ros1_bag(drive(kRos1, 3), "none"))), 3);
}

TEST_F(BagReading, TakesOdometryMessagesWhereTfKnowsNone) {
  std::vector<WrittenMessage> messages = {
      tf_message(kRos1, 99.0, {{"/base_link", "/laser", 0.5, 0.0, 0.0}}, "/tf_static")};
  for (int i = 0; i < 5; ++i) {
    messages.push_back(odometry_message(kRos1, 100.0 + i * 0.2, i * 0.2, 0.0, 0.0));
    messages.push_back(scan_message(kRos1, 100.1 + i * 0.2));
  }
  const RecordedLog log = read(directory_.write("a.bag", ros1_bag({messages}, "none")));
  ASSERT_THAT(log.scans, SizeIs(5));
  EXPECT_NEAR(log.scans[2].T_odom_laser->x, 0.5 + 0.5, 1e-6);
  EXPECT_FALSE(log.scans[2].T_map_laser);
  EXPECT_EQ(remarks_, "");
}

TEST_F(BagReading, WarnsThatItTakesTheLaserToBeAtTheBaseWithoutATransform) {
  const std::vector<WrittenMessage> messages = {odometry_message(kRos1, 100.0, 1.0, 2.0, 0.0),
                                                scan_message(kRos1, 100.1),
                                                odometry_message(kRos1, 100.2, 1.2, 2.0, 0.0)};
  const RecordedLog log = read(directory_.write("a.bag", ros1_bag({messages}, "none")));
  ASSERT_THAT(log.scans, SizeIs(1));
  EXPECT_NEAR(log.scans[0].T_odom_laser->x, 1.1, 1e-6);
  EXPECT_THAT(remarks_, HasSubstr("the laser is taken to be at base_link"));
}

TEST_F(BagReading, GivesScansWithoutAnyOdometryAsWell) {
  const std::vector<WrittenMessage> messages = {scan_message(kRos1, 1.0), scan_message(kRos1, 2.0)};
  const RecordedLog log = read(directory_.write("a.bag", ros1_bag({messages}, "lz4")));
  ASSERT_THAT(log.scans, SizeIs(2));
  EXPECT_FALSE(log.scans[0].T_odom_laser);
  EXPECT_FALSE(log.scans[0].T_map_laser);
}

TEST_F(BagReading, TurnsTheScansOfAnOverheadLaserOver) {
  const std::vector<WrittenMessage> messages = {
      tf_message(kRos1, 1.0, {{"odom", "laser", 3.0, 4.0, 0.5, true}}, "/tf_static"),
      scan_message(kRos1, 1.0)};
  const RecordedLog log = read(directory_.write("a.bag", ros1_bag({messages}, "none")));
  ASSERT_THAT(log.scans, SizeIs(1));
  EXPECT_EQ(log.scans[0].scan.ranges, (std::vector<float>{30.0F, 2.5F, 1.5F}));
  EXPECT_DOUBLE_EQ(log.scans[0].scan.angle_min, -1.0);
  EXPECT_NEAR(log.scans[0].T_odom_laser->yaw, 0.5, 1e-9);
}

TEST_F(BagReading, TakesTheSelectedLidar) {
  const std::vector<WrittenMessage> messages = {scan_message(kRos1, 1.0, "/rear"),
                                                scan_message(kRos1, 2.0, "/front"),
                                                scan_message(kRos1, 3.0, "/rear")};
  const auto path = directory_.write("a.bag", ros1_bag({messages}, "none"));
  EXPECT_THAT(read(path).scans, SizeIs(2));
  EXPECT_THAT(remarks_, HasSubstr("scans of /rear only, not of /front"));
  const RecordedLog front = read(path, {.lidar = "/front"});
  ASSERT_THAT(front.scans, SizeIs(1));
  EXPECT_EQ(front.scans[0].scan.stamp, 2.0);
  const auto none = LogReader::open(path, {.lidar = "/left"});
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().message, HasSubstr("holds no scan of /left"));
}

TEST_F(BagReading, CountsADamagedChunkAndGoesOnBehindIt) {
  for (const char* compression : {"bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    std::string bag = ros1_bag(drive(kRos1, 20), compression);
    const std::size_t chunk = bag.find(std::string("compression=") + compression, bag.size() / 2);
    const std::size_t data = bag.find("size=", chunk) + 5 + 4 + 4;
    for (std::size_t i = data; i < data + 40; ++i) bag[i] = '\x55';
    const RecordedLog log = read(directory_.write("a.bag", bag));
    EXPECT_THAT(log.scans, SizeIs(19));
    ASSERT_EQ(faults_.count(), 1U);
    // The record's length and its fields op and compression lie between.
    const std::size_t record = chunk - 4 - 4 - 4 - 4;
    EXPECT_EQ(faults_.first()[0].where, "byte " + std::to_string(record));
    EXPECT_THAT(faults_.first()[0].message, HasSubstr("chunk"));
  }
}

TEST_F(BagReading, KeepsWhatABagHoldsBeforeItIsCutOff) {
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.bag", ros1_bag(drive(kRos1, 20), "lz4")},
           {"a.mcap", mcap(drive(kCdr, 20), "zstd")}}) {
    SCOPED_TRACE(name);
    const RecordedLog log = read(directory_.write(name, bytes.substr(0, bytes.size() * 2 / 3)));
    EXPECT_GT(log.scans.size(), 5U);
    EXPECT_LT(log.scans.size(), 20U);
    EXPECT_EQ(faults_.count(), 1U);
    EXPECT_THAT(remarks_, HasSubstr("1 broken record left out, the first at byte "));
    EXPECT_THAT(remarks_, HasSubstr("cut off"));
  }
}

TEST_F(BagReading, CountsAMessageWhoseLengthLies) {
  auto chunks = drive(kRos1, 20);
  // The ranges' length is in front of three ranges and of the intensities' length.
  std::string& bytes = chunks[10].back().bytes;
  bytes.replace(bytes.size() - 4 - 12 - 4, 4, "\xff\xff\xff\x7f");
  EXPECT_THAT(read(directory_.write("a.bag", ros1_bag(chunks, "none"))).scans, SizeIs(19));
  ASSERT_EQ(faults_.count(), 1U);
  EXPECT_EQ(faults_.first()[0].message, "LaserScan: ends too early");
}

TEST_F(BagReading, DoesNotTrustTheSizeThatAChunkStates) {
  for (const std::uint32_t told : {0xffffffffU, 0x0fffffffU, 100U}) {
    std::string bag = ros1_bag(drive(kRos1, 3), "lz4");
    const std::size_t size = bag.find("size=", bag.find("compression=lz4")) + 5;
    std::memcpy(&bag[size], &told, sizeof told);
    const auto log = read(directory_.write("a.bag", bag));
    EXPECT_EQ(faults_.count(), 1U) << told;
    EXPECT_THAT(faults_.first()[0].message, HasSubstr("bytes")) << told;
  }
}

TEST_F(BagReading, SortsScansAndLeavesOutThoseThatRepeatTheOneBefore) {
  const std::vector<WrittenMessage> messages = {scan_message(kRos1, 1.0), scan_message(kRos1, 3.0),
                                                scan_message(kRos1, 2.0), scan_message(kRos1, 3.0),
                                                scan_message(kRos1, 4.0)};
  EXPECT_THAT(read(directory_.write("a.bag", ros1_bag({messages}, "none"))).scans, SizeIs(4));
  EXPECT_EQ(faults_.count(), 1U);
  EXPECT_EQ(faults_.first()[0].where, "stamp 3.000000 s");
}

TEST_F(BagReading, UsesEachScanWithItsOwnGeometry) {
  std::vector<WrittenMessage> messages = {scan_message(kRos1, 1.0), scan_message(kRos1, 2.0),
                                          scan_message(kRos1, 3.0)};
  messages[1].bytes = laser_scan(kRos1, 2.0, {1.0F, 2.0F, 3.0F, 4.0F}, "laser", {-1.0F, 0.5F});
  messages[2].bytes = laser_scan(kRos1, 3.0, {1.0F, 2.0F, 3.0F}, "laser", {-1.0F, 1.0F, 2.5F});
  const RecordedLog log = read(directory_.write("a.bag", ros1_bag({messages}, "none")));
  ASSERT_THAT(log.scans, SizeIs(3));
  EXPECT_EQ(faults_.count(), 0U);
  EXPECT_EQ(log.header.beams, 3U);
  EXPECT_EQ(log.scans[0].scan.range_max, 20.0);
  EXPECT_THAT(log.scans[1].scan.ranges, SizeIs(4));
  EXPECT_EQ(log.scans[1].scan.angle_increment, 0.5);
  EXPECT_EQ(log.scans[2].scan.range_max, 2.5);
}

TEST_F(BagReading, TakesAnInfiniteRangeMaxForNoLimit) {
  WrittenMessage message = scan_message(kRos1, 1.0);
  message.bytes =
      laser_scan(kRos1, 1.0, {1.0F, 200.0F, kInfinity}, "laser", {-1.0F, 1.0F, kInfinity});
  const RecordedLog log = read(directory_.write("a.bag", ros1_bag({{message}}, "none")));
  ASSERT_THAT(log.scans, SizeIs(1));
  EXPECT_TRUE(log.scans[0].scan.has_return(1));
  EXPECT_FALSE(log.scans[0].scan.has_return(2));
}

TEST_F(BagReading, ReadsARos1BagWhoseIndexClaimsAWrongLength) {
  std::string bag = ros1_bag(drive(kRos1, 20), "none");
  const std::string right = index_record(3, 3 * 12);
  for (std::size_t at = bag.find(right); at != std::string::npos; at = bag.find(right, at + 1)) {
    bag.replace(at, right.size(), index_record(3, 3 * 20));
  }
  const RecordedLog log = read(directory_.write("a.bag", bag));
  EXPECT_THAT(log.scans, SizeIs(20));
  EXPECT_EQ(faults_.count(), 0U);
}

// --- whose scans, transforms and odometry -------------------------------------------------------

TEST_F(BagReading, TakesTheScansOfMostBeams) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 3; ++i) {
    messages.push_back(scan_message(kCdr, 1.0 + i, "/cliff"));
    messages.push_back(scan_message(kCdr, 1.1 + i, "/scan"));
    messages.back().bytes =
        laser_scan(kCdr, 1.1 + i, std::vector<float>(50, 2.0F), "laser", {-1.0F, 0.01F});
  }
  const auto path = directory_.write("a.mcap", mcap({messages}, ""));
  EXPECT_EQ(read(path).header.beams, 50U);
  EXPECT_THAT(remarks_, HasSubstr("scans of /scan only, not of /cliff"));
  EXPECT_EQ(read(path, {.lidar = "/cliff"}).header.beams, 3U);
}

TEST_F(BagReading, NamesTopicsTypesAndCountsWhenThereIsNoScan) {
  const std::vector<WrittenMessage> messages = {
      odometry_message(kCdr, 1.0, 0.0, 0.0, 0.0),
      {1.0, "/camera", "sensor_msgs/msg/Image", "pixels"},
      {2.0, "/camera", "sensor_msgs/msg/Image", "pixels"}};
  const auto log = LogReader::open(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_FALSE(log.ok());
  EXPECT_THAT(log.error().message,
              HasSubstr("holds no scan; its topics are /odom (nav_msgs/msg/Odometry, 1 messages), "
                        "/camera (sensor_msgs/msg/Image, 2 messages)"));
}

TEST_F(BagReading, TakesTheFirstEchoOfAMultiEchoScan) {
  const std::vector<WrittenMessage> messages = {
      {1.0, "/echoes", "sensor_msgs/MultiEchoLaserScan",
       multi_echo_scan(kRos1, 1.0, {{1.0F, 4.0F}, {}, {3.0F}})}};
  const RecordedLog log = read(directory_.write("a.bag", ros1_bag({messages}, "none")));
  ASSERT_THAT(log.scans, SizeIs(1));
  EXPECT_EQ(log.scans[0].scan.ranges[0], 1.0F);
  EXPECT_FALSE(log.scans[0].scan.has_return(1));
  EXPECT_EQ(log.scans[0].scan.ranges[2], 3.0F);
}

/// A cylinder wall of 3 m radius, a point per degree, from 0.5 m below the sensor to 0.5 m above;
/// nearer points at the height of the floor.
std::vector<WrittenPoint> cylinder() {
  std::vector<WrittenPoint> points;
  for (int degree = -180; degree < 180; ++degree) {
    const auto angle = static_cast<float>(degree * kPi / 180.0);
    for (const float z : {-0.5F, 0.0F, 0.5F}) {
      points.push_back({3.0F * std::cos(angle), 3.0F * std::sin(angle), z});
    }
    points.push_back({std::cos(angle), std::sin(angle), -0.6F});
  }
  return points;
}

TEST_F(BagReading, CutsAPointCloudWhereThereIsNoScan) {
  std::vector<WrittenPoint> points = cylinder();
  points.push_back({0.0F, 0.0F, 0.0F});  // A point without return.
  const std::vector<WrittenMessage> messages = {
      {1.0, "/points", "sensor_msgs/msg/PointCloud2", point_cloud(kCdr, 1.0, points)}};
  const auto path = directory_.write("a.mcap", mcap({messages}, ""));
  const RecordedLog log = read(path);
  ASSERT_THAT(log.scans, SizeIs(1));
  const LaserScan& scan = log.scans[0].scan;
  ASSERT_THAT(scan.ranges, SizeIs(360));
  EXPECT_NEAR(scan.angle_increment, kPi / 180.0, 1e-6);
  for (const float range : scan.ranges) EXPECT_NEAR(range, 3.0F, 1e-4F);
  EXPECT_THAT(remarks_, HasSubstr("-0.15 to 0.15 m above the sensor"));
  const RecordedLog floor = read(path, {.height = {-0.7, -0.55}});
  ASSERT_THAT(floor.scans, SizeIs(1));
  EXPECT_NEAR(floor.scans[0].scan.ranges[0], 1.0F, 1e-4F);
}

TEST_F(BagReading, CutsThePointCloudOfACameraLevel) {
  // The optical frame looks along z, y points down: the wall 2 m ahead, the floor 0.5 m below.
  std::vector<WrittenPoint> points;
  for (int i = -20; i <= 20; ++i) {
    points.push_back({0.05F * static_cast<float>(i), 0.0F, 2.0F});
    points.push_back({0.05F * static_cast<float>(i), 0.5F, 1.0F});
  }
  WireWriter optical(kCdr);
  optical.number(std::uint32_t{1}).header(1.0, "base_link").text("laser");
  optical.number(0.2).number(0.0).number(0.5);
  optical.number(-0.5).number(0.5).number(-0.5).number(0.5);
  const std::vector<WrittenMessage> messages = {
      {0.5, "/tf_static", "tf2_msgs/msg/TFMessage", optical.bytes()},
      odometry_message(kCdr, 0.9, 5.0, 0.0, 0.0),
      {1.0, "/points", "sensor_msgs/msg/PointCloud2", point_cloud(kCdr, 1.0, points)},
      odometry_message(kCdr, 1.1, 5.0, 0.0, 0.0)};
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(1));
  ASSERT_TRUE(log.scans[0].T_odom_laser);
  std::size_t returns = 0;
  for (const Point2& point : returns_as_points(log.scans[0].scan)) {
    EXPECT_NEAR((*log.scans[0].T_odom_laser * point).x(), 5.0 + 0.2 + 2.0, 0.02);
    ++returns;
  }
  EXPECT_GE(returns, 38U);  // Some of the outer points share a bearing.
}

TEST_F(BagReading, TakesTheTransformsOfTheScansNamespace) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(tf_message(kCdr, stamp, {{"odom", "laser", 0.1 * i, 0.0, 0.0}}, "/a/tf"));
    messages.push_back(tf_message(kCdr, stamp, {{"odom", "laser", 50.0, 0.0, 0.0}}, "/b/tf"));
    messages.push_back(tf_message(kCdr, stamp, {{"odom", "laser", 70.0, 0.0, 0.0}}, "/tf"));
    messages.push_back(scan_message(kCdr, stamp, "/a/front/scan"));
    messages.push_back(scan_message(kCdr, stamp, "/b/scan"));
    messages.push_back(scan_message(kCdr, stamp, "/c/scan"));
  }
  const auto path = directory_.write("a.mcap", mcap({messages}, ""));
  const auto x_of = [&](const std::string& topic) {
    const RecordedLog log = read(path, {.lidar = topic});
    return log.scans.size() == 5 ? log.scans[4].T_odom_laser.value_or(Pose2{}).x : NAN;
  };
  EXPECT_NEAR(x_of("/a/front/scan"), 0.4, 1e-9);
  EXPECT_THAT(remarks_, HasSubstr("no transforms of /b/tf, /tf"));
  EXPECT_NEAR(x_of("/b/scan"), 50.0, 1e-9);
  EXPECT_NEAR(x_of("/c/scan"), 70.0, 1e-9);
}

TEST_F(BagReading, TakesOneOfSeveralOdometryTopics) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(odometry_message(kCdr, stamp, 30.0, 0.0, 0.0, "/b/odom"));
    messages.push_back(odometry_message(kCdr, stamp, 20.0, 0.0, 0.0, "/a/filtered"));
    messages.push_back(odometry_message(kCdr, stamp, 10.0, 0.0, 0.0, "/a/odom"));
    messages.push_back(scan_message(kCdr, stamp, "/a/scan"));
  }
  const auto path = directory_.write("a.mcap", mcap({messages}, ""));
  EXPECT_NEAR(read(path).scans.at(3).T_odom_laser->x, 10.0, 1e-9);
  EXPECT_THAT(remarks_, HasSubstr("odometry of /a/odom where tf has none, not of /b/odom, "
                                  "/a/filtered; --odom chooses"));
  EXPECT_NEAR(read(path, {.odometry = "/b/odom"}).scans.at(3).T_odom_laser->x, 30.0, 1e-9);
}

TEST_F(BagReading, PrefersTheChosenOdometryToTf) {
  std::vector<WrittenMessage> messages = {
      tf_message(kCdr, 0.9, {{"base_link", "laser", 0.5, 0.0, 0.0}}, "/tf_static")};
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(tf_message(kCdr, stamp, {{"odom", "base_link", 0.1 * i, 0.0, 0.0}}));
    messages.push_back(odometry_message(kCdr, stamp, 7.0, 0.0, 0.0, "/wheels"));
    messages.push_back(scan_message(kCdr, stamp));
  }
  const auto path = directory_.write("a.mcap", mcap({messages}, ""));
  EXPECT_NEAR(read(path).scans.at(3).T_odom_laser->x, 0.8, 1e-9);
  EXPECT_NEAR(read(path, {.odometry = "/wheels"}).scans.at(3).T_odom_laser->x, 7.5, 1e-9);
}

TEST_F(BagReading, LeavesOutATransformThatIsNoneAndTakesTheOthersOfItsMessage) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(tf_message(
        kCdr, stamp, {{"base_link", "camera", NAN, 0.0, 0.0}, {"odom", "laser", 7.0, 0.0, 0.0}}));
    messages.push_back(scan_message(kCdr, stamp));
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  EXPECT_NEAR(log.scans.at(3).T_odom_laser->x, 7.0, 1e-9);
  EXPECT_THAT(remarks_, HasSubstr("TFMessage: from base_link to camera: translation nan 0 0.2, "
                                  "rotation 0 0 0 1 (x y z w), expected finite numbers and a unit "
                                  "quaternion"));
}

TEST_F(BagReading, FindsTopicsWithoutTheSlashInFront) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(odometry_message(kCdr, stamp, 7.0, 0.0, 0.0, "/wheels"));
    messages.push_back(scan_message(kCdr, stamp, "/front"));
    messages.push_back(scan_message(kCdr, stamp, "/rear"));
  }
  const auto path = directory_.write("a.mcap", mcap({messages}, ""));
  const RecordedLog log = read(path, {.lidar = "rear", .odometry = "wheels"});
  ASSERT_EQ(log.scans.size(), 5U);
  EXPECT_NEAR(log.scans[3].T_odom_laser->x, 7.0, 1e-9);
  EXPECT_THAT(remarks_, HasSubstr("scans of /rear only, not of /front"));
}

TEST_F(BagReading, NamesChosenTopicsThatAreNotThere) {
  const auto path = directory_.write("a.mcap", mcap(drive(kCdr, 5), ""));
  read(path, {.odometry = "/wheels"});
  EXPECT_THAT(remarks_,
              HasSubstr("no nav_msgs/Odometry of /wheels (--odom), nor of any other topic"));
  const auto log = LogReader::open(path, {.lidar = "/side"});
  ASSERT_FALSE(log.ok());
  EXPECT_THAT(log.error().message, HasSubstr("holds no scan of /side; its topics are"));
}

TEST_F(BagReading, NamesAnAngleMaxThatContradictsTheIncrement) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back({stamp, "/scan", "sensor_msgs/msg/LaserScan",
                        laser_scan(kCdr, stamp, {1.0F, 2.0F, 3.0F, 4.0F}, "laser",
                                   {.angle_min = 1.0F, .angle_increment = -0.5F})});
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  EXPECT_EQ(log.scans.at(0).scan.angle_increment, -0.5);
  EXPECT_THAT(remarks_, HasSubstr("angle_max does not fit in 5 scans, in the first it is 1 rad, "
                                  "where angle_min 1, angle_increment -0.5 and 4 beams end at "
                                  "-0.5 rad: angle_increment is used, angle_max is not"));
}

TEST_F(BagReading, TakesAnyFrameAboveTheBaseForOdometry) {
  for (const char* odometry_frame : {"wheel_odom", "world", "r1/dead_reckoning"}) {
    SCOPED_TRACE(odometry_frame);
    std::vector<WrittenMessage> messages = {
        tf_message(kCdr, 0.9, {{"base_link", "laser", 0.5, 0.0, 0.0}}, "/tf_static")};
    for (int i = 0; i < 5; ++i) {
      const double stamp = 1.0 + 0.1 * i;
      messages.push_back(tf_message(kCdr, stamp, {{odometry_frame, "base_link", 0.1 * i, 0, 0}}));
      messages.push_back(scan_message(kCdr, stamp));
    }
    const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
    ASSERT_THAT(log.scans, SizeIs(5));
    for (std::size_t i = 0; i < 5; ++i) {
      ASSERT_TRUE(log.scans[i].T_odom_laser);
      EXPECT_NEAR(log.scans[i].T_odom_laser->x, 0.1 * static_cast<double>(i) + 0.5, 1e-9);
    }
  }
}

TEST_F(BagReading, TakesNoPartOfTheRobotForOdometry) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 30; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(tf_message(kCdr, stamp, {{"chassis", "laser", 0.5, 0.0, 0.0}}));
    messages.push_back(scan_message(kCdr, stamp));
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(30));
  for (const LogScan& scan : log.scans) EXPECT_FALSE(scan.T_odom_laser);
  EXPECT_THAT(remarks_, HasSubstr("no odometry for 20 scans in the frame laser"));
}

TEST_F(BagReading, ConnectsOdometryOfABaseLinkThatIsBelowTheBaseFootprint) {
  std::vector<WrittenMessage> messages = {tf_message(
      kCdr, 0.9,
      {{"base_footprint", "base_link", 0.1, 0.0, 0.0}, {"base_footprint", "laser", 0.6, 0.0, 0.0}},
      "/tf_static")};
  for (int i = 0; i < 5; ++i) {
    messages.push_back(odometry_message(kCdr, 1.0 + 0.1 * i, 0.1 * i, 0.0, 0.0));
    messages.push_back(scan_message(kCdr, 1.0 + 0.1 * i));
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(5));
  EXPECT_NEAR(log.scans[4].T_odom_laser->x, 0.4 + 0.5, 1e-9);
}

TEST_F(BagReading, TakesTheRootAboveTheLaserForABaseThatTfDoesNotKnow) {
  std::vector<WrittenMessage> messages = {
      tf_message(kCdr, 0.9, {{"base_footprint", "laser", 0.6, 0.0, 0.0}}, "/tf_static")};
  for (int i = 0; i < 5; ++i) {
    messages.push_back(odometry_message(kCdr, 1.0 + 0.1 * i, 0.1 * i, 0.0, 0.0));
    messages.push_back(scan_message(kCdr, 1.0 + 0.1 * i));
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(5));
  EXPECT_NEAR(log.scans[4].T_odom_laser->x, 0.4 + 0.6, 1e-9);
  EXPECT_THAT(remarks_, HasSubstr("no transform from base_link to laser: base_footprint is taken "
                                  "to be base_link"));
}

TEST_F(BagReading, SaysWhyNoScanHasOdometry) {
  std::vector<WrittenMessage> messages = {
      tf_message(kCdr, 1000.0, {{"base_link", "laser", 0.5, 0.0, 0.0}}, "/tf_static")};
  for (int i = 0; i < 10; ++i) {
    const double stamp = 1000.0 + 0.1 * i;
    messages.push_back(tf_message(kCdr, stamp, {{"odom", "base_link", 0.1 * i, 0.0, 0.0}}));
    messages.push_back(odometry_message(kCdr, stamp, 0.1 * i, 0.0, 0.0));
    messages.push_back(scan_message(kCdr, 12.0 + 0.1 * i));  // The driver's uptime.
    messages.back().received = stamp;
  }
  EXPECT_THAT(read(directory_.write("a.mcap", mcap({messages}, ""))).scans, SizeIs(10));
  EXPECT_EQ(remarks_,
            "no odometry for 10 scans in the frame laser, stamped 12.000 to 12.900 s; messages of "
            "/odom from odom to base_link are stamped 1000.000 to 1000.900 s; frames above laser: "
            "base_link odom; transforms are stamped 1000.000 to 1000.900 s");
}

}  // namespace
}  // namespace cornerfix::evaluation
