// Bags of all kinds through the door that the commands use.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <numbers>

#include "cli/log_reader.hpp"
#include "unit/cli/bag/bag_writers.hpp"
#include "unit/cli/temporary_directory.hpp"

namespace cornerfix::cli {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

constexpr double kPi = std::numbers::pi;
constexpr WireFormat kRos1 = WireFormat::kRos1;
constexpr WireFormat kCdr = WireFormat::kCdr;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

WrittenMessage scan_message(WireFormat format, double stamp, const std::string& topic = "/scan") {
  const char* type = format == kRos1 ? "sensor_msgs/LaserScan" : "sensor_msgs/msg/LaserScan";
  return {stamp + 0.01, topic, type, laser_scan(format, stamp, {1.5F, 2.5F, 30.0F})};
}

WrittenMessage odometry_message(WireFormat format, double stamp, double x, double y, double yaw) {
  const char* type = format == kRos1 ? "nav_msgs/Odometry" : "nav_msgs/msg/Odometry";
  return {stamp + 0.01, "/odom", type, odometry(format, stamp, x, y, yaw)};
}

WrittenMessage tf_message(WireFormat format, double stamp,
                          const std::vector<WrittenTransform>& list,
                          const std::string& topic = "/tf") {
  return {stamp + 0.01, topic, format == kRos1 ? "tf2_msgs/TFMessage" : "tf2_msgs/msg/TFMessage",
          transforms(format, stamp, list)};
}

/// A robot that drives along y = 1 at 1 m/s, its laser 0.5 m ahead; the map lies a quarter turn off
/// the odometry. Scans half-way between the transforms.
std::vector<std::vector<WrittenMessage>> drive(WireFormat format, std::size_t scans) {
  std::vector<std::vector<WrittenMessage>> chunks;
  chunks.push_back(
      {tf_message(format, 99.0, {{"base_link", "laser", 0.5, 0.0, 0.0}}, "/tf_static")});
  for (std::size_t i = 0; i <= scans; ++i) {
    const double x = 0.1 * static_cast<double>(i);
    const double stamp = 100.0 + x;
    chunks.push_back(
        {tf_message(format, stamp,
                    {{"odom", "base_link", x, 1.0, 0.0}, {"map", "odom", 10.0, 0.0, kPi / 2.0}}),
         {stamp, "/camera", "sensor_msgs/Image", "pixels"}});
    if (i < scans) chunks.back().push_back(scan_message(format, stamp + 0.05));
  }
  return chunks;
}

void expect_drive(const RecordedLog& log, std::size_t scans) {
  ASSERT_THAT(log.scans, SizeIs(scans));
  EXPECT_EQ(log.header.beams, 3U);
  EXPECT_DOUBLE_EQ(log.header.lidar.angle_min, -1.0);
  EXPECT_DOUBLE_EQ(log.header.lidar.range_max, 20.0);
  for (std::size_t i = 0; i < scans; ++i) {
    const LogScan& scan = log.scans[i];
    const double x = 0.1 * static_cast<double>(i) + 0.05;
    EXPECT_NEAR(scan.scan.stamp, 100.0 + x, 1e-6);
    EXPECT_EQ(scan.scan.ranges, (std::vector<float>{1.5F, 2.5F, 30.0F}));
    ASSERT_TRUE(scan.T_odom_laser);
    EXPECT_NEAR(scan.T_odom_laser->x, x + 0.5, 1e-5);
    EXPECT_NEAR(scan.T_odom_laser->y, 1.0, 1e-9);
    ASSERT_TRUE(scan.T_map_laser);
    EXPECT_NEAR(scan.T_map_laser->x, 9.0, 1e-9);
    EXPECT_NEAR(scan.T_map_laser->y, x + 0.5, 1e-5);
    EXPECT_NEAR(scan.T_map_laser->yaw, kPi / 2.0, 1e-9);
  }
}

class BagReading : public testing::Test {
 protected:
  /// All scans, and what was left out on the way.
  RecordedLog read(const std::filesystem::path& path, const std::string& lidar = "") {
    Result<LogReader> reader = LogReader::open(path, lidar);
    if (!reader) {
      ADD_FAILURE() << reader.error().message;
      return {};
    }
    RecordedLog log = read_all(*reader);
    faults_ = reader->faults();
    remarks_ = remarks(*reader);
    return log;
  }

  TemporaryDirectory directory_;
  LogFaults faults_;
  std::string remarks_;
};

TEST_F(BagReading, ReadsRos1BagsPackedEachWay) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    const auto path = directory_.write("drive.bag", ros1_bag(drive(kRos1, 20), compression));
    const RecordedLog log = read(path);
    EXPECT_EQ(log.header.name, "drive");
    expect_drive(log, 20);
    EXPECT_EQ(remarks_, "");
  }
}

TEST_F(BagReading, ReadsMcapPackedEachWay) {
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

TEST_F(BagReading, TellsBagsByWhatTheyBeginWith) {
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

TEST_F(BagReading, SaysThatItTakesTheLaserToBeAtTheBaseWhereNothingTellsItsPlace) {
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

TEST_F(BagReading, TakesTheLidarThatItIsTold) {
  const std::vector<WrittenMessage> messages = {scan_message(kRos1, 1.0, "/rear"),
                                                scan_message(kRos1, 2.0, "/front"),
                                                scan_message(kRos1, 3.0, "/rear")};
  const auto path = directory_.write("a.bag", ros1_bag({messages}, "none"));
  EXPECT_THAT(read(path).scans, SizeIs(2));
  EXPECT_EQ(remarks_, "scans of /rear only, not of /front");
  const RecordedLog front = read(path, "/front");
  ASSERT_THAT(front.scans, SizeIs(1));
  EXPECT_EQ(front.scans[0].scan.stamp, 2.0);
  const auto none = LogReader::open(path, "/left");
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

TEST_F(BagReading, DoesNotBelieveTheSizeThatAChunkTells) {
  for (const std::uint32_t told : {0xffffffffU, 0x0fffffffU, 100U}) {
    std::string bag = ros1_bag(drive(kRos1, 3), "lz4");
    const std::size_t size = bag.find("size=", bag.find("compression=lz4")) + 5;
    std::memcpy(&bag[size], &told, sizeof told);
    const auto log = read(directory_.write("a.bag", bag));
    EXPECT_EQ(faults_.count(), 1U) << told;
    EXPECT_THAT(faults_.first()[0].message, HasSubstr("bytes")) << told;
  }
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

TEST_F(BagReading, CountsScansThatGoBackInTime) {
  const std::vector<WrittenMessage> messages = {scan_message(kRos1, 1.0), scan_message(kRos1, 3.0),
                                                scan_message(kRos1, 2.0), scan_message(kRos1, 3.0),
                                                scan_message(kRos1, 4.0)};
  EXPECT_THAT(read(directory_.write("a.bag", ros1_bag({messages}, "none"))).scans, SizeIs(3));
  EXPECT_EQ(faults_.count(), 2U);
  EXPECT_EQ(faults_.first()[0].where, "stamp 2.000000 s");
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

TEST_F(BagReading, SaysWhatIsWrongWithAFileThatIsNoBag) {
  const auto message_of = [&](const std::string& name, const std::string& content) {
    const auto log = LogReader::open(directory_.write(name, content));
    return log.ok() ? "" : log.error().message;
  };
  EXPECT_THAT(message_of("a.bag", "#ROSBAG V1.2\n"), HasSubstr("bag of format 1.2, expected 2.0"));
  EXPECT_THAT(message_of("a.bag", "PK"), HasSubstr("unknown kind of log"));
  EXPECT_THAT(message_of("a.bag", "#ROSBAG V2.0\n"), HasSubstr("holds no scan"));
  EXPECT_THAT(message_of("a.bag",
                         "#ROSBAG V2.0\n\xff\xff\xff\xff"
                         "abc"),
              HasSubstr("the first at byte 13: a record header that is cut off"));
  EXPECT_THAT(message_of("a.mcap", "\x89MCAP0\r\n\x06\xff\xff\xff\xff\xff\xff\xff\xff"),
              HasSubstr("the first at byte 8: a record that is cut off"));
  EXPECT_THAT(message_of("a.db3", std::string("SQLite format 3\0nothing else", 28)),
              HasSubstr("is no bag of ROS 2 that can be read"));
  EXPECT_THAT(LogReader::open(directory_.path()).error().message, HasSubstr("is a directory"));
}

TEST_F(BagReading, SurvivesEveryCutAndEveryFlippedByte) {
  for (const auto& [name, good] : std::vector<std::pair<std::string, std::string>>{
           {"a.bag", ros1_bag({drive(kRos1, 1)[0], drive(kRos1, 1)[1]}, "none")},
           {"a.mcap", mcap({drive(kCdr, 1)[0], drive(kCdr, 1)[1]}, "zstd")}}) {
    for (std::size_t at = 13; at < good.size(); at += at < 4000 && name == "a.bag" ? 97 : 3) {
      std::string flipped = good;
      flipped[at] = static_cast<char>(flipped[at] ^ 0x81);
      for (const std::string& bytes : {good.substr(0, at), flipped}) {
        Result<LogReader> reader = LogReader::open(directory_.write(name, bytes));
        if (!reader) {
          EXPECT_NE(reader.error().message, "");
        } else {
          EXPECT_LE(read_all(*reader).scans.size(), 1U);
        }
      }
    }
  }
}

}  // namespace
}  // namespace cornerfix::cli
