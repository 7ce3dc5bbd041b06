// Bags of robots that are not as their documents say: frames with two parents, stamps that are
// alike, recorders that were never closed.
#include <sys/stat.h>

#include <SQLiteCpp/SQLiteCpp.h>

#include "unit/evaluation/datasets/bag/bag_reading.hpp"

#include <string>
#include <utility>
#include <vector>

namespace cornerfix::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

TEST_F(BagReading, TakesOdometryAndMapThatTfHasBelowTheBase) {
  std::vector<WrittenMessage> messages = {
      tf_message(kCdr, 0.9, {{"base_link", "laser", 0.5, 0.0, 0.0}}, "/tf_static")};
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(tf_message(
        kCdr, stamp,
        {{"base_link", "odom", -0.1 * i, 0.0, 0.0}, {"base_link", "map", 0.0, 0.0, kPi / 2.0}}));
    messages.push_back(scan_message(kCdr, stamp));
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(5));
  ASSERT_TRUE(log.scans[4].T_odom_laser && log.scans[4].T_map_laser);
  EXPECT_NEAR(log.scans[4].T_odom_laser->x, 0.4 + 0.5, 1e-9);
  EXPECT_NEAR(log.scans[4].T_map_laser->y, -0.5, 1e-9);
}

/// A robot that drives along x at 1 m/s; the last range counts the scans.
std::vector<WrittenMessage> numbered_drive(int scans) {
  std::vector<WrittenMessage> messages = {
      tf_message(kCdr, 0.9, {{"base_link", "laser", 0.5, 0.0, 0.0}}, "/tf_static")};
  for (int i = 0; i < scans; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(tf_message(kCdr, stamp, {{"odom", "base_link", 0.1 * i, 0.0, 0.0}}));
    messages.push_back(
        {stamp + 0.01, "/scan", "sensor_msgs/msg/LaserScan",
         laser_scan(kCdr, stamp, {1.0F, 2.0F, 3.0F + 0.01F * static_cast<float>(i)})});
  }
  return messages;
}

void expect_odometry_along_x(const RecordedLog& log, std::size_t scans) {
  ASSERT_THAT(log.scans, SizeIs(scans));
  for (std::size_t i = 0; i < scans; ++i) {
    ASSERT_TRUE(log.scans[i].T_odom_laser) << i;
    EXPECT_NEAR(log.scans[i].T_odom_laser->x, 0.1 * static_cast<double>(i) + 0.5, 1e-6) << i;
  }
}

TEST_F(BagReading, FindsOdometryBesideASecondParentOfTheBase) {
  for (const bool map_is_first : {true, false}) {
    SCOPED_TRACE(map_is_first);
    std::vector<WrittenMessage> messages = {
        tf_message(kCdr, 0.9, {{"base_link", "laser", 0.5, 0.0, 0.0}}, "/tf_static")};
    for (int i = 0; i < 8; ++i) {
      const double stamp = 1.0 + 0.1 * i;
      std::vector<WrittenTransform> parents = {{"map", "base_link", 7.0, 0.1 * i, kPi / 2.0},
                                               {"odom", "base_link", 0.1 * i, 0.0, 0.0}};
      if (!map_is_first) std::swap(parents[0], parents[1]);
      messages.push_back(tf_message(kCdr, stamp, parents));
      messages.push_back(scan_message(kCdr, stamp));
    }
    const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
    expect_odometry_along_x(log, 8);
    for (const LogScan& scan : log.scans) {
      ASSERT_TRUE(scan.T_map_laser);
      EXPECT_NEAR(scan.T_map_laser->x, 7.0, 1e-9);
    }
  }
}

TEST_F(BagReading, FindsOdometryAboveABaseFootprintThatIsBelowTheBaseToo) {
  std::vector<WrittenMessage> messages = {tf_message(
      kCdr, 0.9,
      {{"base_link", "base_footprint", 0.0, 0.0, 0.0}, {"base_link", "laser", 0.5, 0.0, 0.0}},
      "/tf_static")};
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(tf_message(kCdr, stamp, {{"odom", "base_footprint", 0.1 * i, 0.0, 0.0}}));
    messages.push_back(scan_message(kCdr, stamp));
  }
  expect_odometry_along_x(read(directory_.write("a.mcap", mcap({messages}, ""))), 5);
}

TEST_F(BagReading, PlacesScansOfOneStampByTheTimeOfRecording) {
  std::vector<WrittenMessage> messages = numbered_drive(40);
  int i = 0;
  for (WrittenMessage& message : messages) {
    if (message.topic != "/scan") continue;
    const double whole_seconds = 1.0 + i / 10;
    message.bytes =
        laser_scan(kCdr, whole_seconds, {1.0F, 2.0F, 3.0F + 0.01F * static_cast<float>(i)});
    ++i;
  }
  expect_odometry_along_x(read(directory_.write("a.mcap", mcap({messages}, ""))), 40);
  EXPECT_EQ(remarks_,
            "36 scans have the stamp of the scan before: they are placed by the time of recording");
}

TEST_F(BagReading, FindsOdometryWhenTheClockOfTheRecordingIsSetBack) {
  std::vector<WrittenMessage> messages = numbered_drive(300);
  std::vector<WrittenMessage> twice = messages;
  twice.insert(twice.end(), messages.begin(), messages.end());
  const RecordedLog log = read(directory_.write("a.mcap", mcap({twice}, "")));
  ASSERT_THAT(log.scans, SizeIs(600));
  for (const LogScan& scan : log.scans) ASSERT_TRUE(scan.T_odom_laser) << scan.scan.stamp;
}

TEST_F(BagReading, FindsOdometryWhenTheClockOfTheRecordingStandsStill) {
  std::vector<WrittenMessage> messages = numbered_drive(300);
  for (WrittenMessage& message : messages) message.received = 5.0;
  expect_odometry_along_x(read(directory_.write("a.mcap", mcap({messages}, ""))), 300);
}

TEST_F(BagReading, LeavesOutAScanWhoseStampIsNoTime) {
  std::vector<WrittenMessage> messages = numbered_drive(20);
  messages[20].bytes = laser_scan(kCdr, 4e8, {1.0F, 2.0F, 9.0F});
  ASSERT_EQ(messages[20].topic, "/scan");
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(19));
  for (const LogScan& scan : log.scans) EXPECT_FALSE(scan.begins_run);
  EXPECT_THAT(remarks_, HasSubstr("1 broken record left out, the first at stamp 400000000.000000 "
                                  "s: not between those of the scans before and behind it"));
}

TEST_F(BagReading, TakesOneOfTwoLidarsOfOneTopic) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 40; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back({stamp, "/scan", "sensor_msgs/msg/LaserScan",
                        laser_scan(kCdr, stamp, {1.0F, 2.0F, 3.0F + 0.1F * static_cast<float>(i)},
                                   i % 2 == 0 ? "front" : "rear")});
  }
  EXPECT_THAT(read(directory_.write("a.mcap", mcap({messages}, ""))).scans, SizeIs(20));
  EXPECT_THAT(remarks_, HasSubstr("scans of /scan in the frame front only, not in rear: "
                                  "expected one lidar per topic"));
}

TEST_F(BagReading, GoesOnWithALidarWhoseFrameGotAnotherName) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 40; ++i) {
    const double stamp = 1.0 + 0.1 * i + (i < 20 ? 0.0 : 5.0);
    messages.push_back({stamp, "/scan", "sensor_msgs/msg/LaserScan",
                        laser_scan(kCdr, stamp, {1.0F, 2.0F, 3.0F + 0.1F * static_cast<float>(i)},
                                   i < 20 ? "laser" : "base_scan")});
  }
  EXPECT_THAT(read(directory_.write("a.mcap", mcap({messages}, ""))).scans, SizeIs(40));
  EXPECT_THAT(remarks_, Not(HasSubstr("in the frame laser only")));
}

TEST_F(BagReading, TakesTheStampZeroOfASimulation) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 20; ++i) {
    const double stamp = 0.1 * i;
    messages.push_back(
        {1e9 + stamp, "/scan", "sensor_msgs/msg/LaserScan",
         laser_scan(kCdr, stamp, {1.0F, 2.0F, 3.0F + 0.1F * static_cast<float>(i)})});
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(20));
  EXPECT_NEAR(log.scans[0].scan.stamp, 0.0, 1e-6);
  for (const LogScan& scan : log.scans) EXPECT_FALSE(scan.begins_run);
}

/// A cloud of three points ahead, in rows of one point each, whose row_step is this.
std::string cloud_of_rows(std::uint32_t height, std::uint32_t width, std::uint32_t row_step) {
  constexpr std::uint8_t kFloat32 = 7;
  constexpr std::uint32_t kPointStep = 16;
  WireWriter writer(kCdr);
  writer.header(1.0, "laser").number(height).number(width).number(std::uint32_t{3});
  std::uint32_t offset = 0;
  for (const char* name : {"x", "y", "z"}) {
    writer.text(name).number(offset).number(kFloat32).number(std::uint32_t{1});
    offset += sizeof(float);
  }
  writer.number(std::uint8_t{0}).number(kPointStep).number(row_step).number(3 * kPointStep);
  for (const float y : {-1.0F, 0.0F, 1.0F}) {
    for (const float value : {2.0F, y, 0.0F, 0.0F}) writer.number(value);
  }
  return writer.number(std::uint8_t{1}).bytes();
}

TEST_F(BagReading, ReadsAPointCloudWhoseRowStepIsWrong) {
  const auto message = [](std::uint32_t height, std::uint32_t width, std::uint32_t row_step) {
    return WrittenMessage{1.0, "/points", "sensor_msgs/msg/PointCloud2",
                          cloud_of_rows(height, width, row_step)};
  };
  for (const std::uint32_t row_step : {0U, 1U, 16U, 48U}) {
    const RecordedLog log = read(directory_.write("a.mcap", mcap({{message(3, 1, row_step)}}, "")));
    ASSERT_THAT(log.scans, SizeIs(1)) << row_step;
    EXPECT_THAT(returns_as_points(log.scans[0].scan), SizeIs(3)) << row_step;
  }
  // The product of these sizes is 0 in 64 bits.
  const auto wrong =
      LogReader::open(directory_.write("a.mcap", mcap({{message(1U << 30U, 1U << 30U, 0)}}, "")));
  EXPECT_THAT(wrong.error().message, HasSubstr("48 bytes of data, where height 1073741824"));
}

TEST_F(BagReading, ReadsARos1BagThatWasNeverClosed) {
  // The recorder writes the size of a chunk when it is full: until then it is 0.
  std::string bag = ros1_bag({messages_of(drive(kRos1, 20))}, "none");
  const std::size_t size = bag.find("size=") + 5;
  bag.replace(size, 4, std::string(4, '\0'));
  const std::size_t length = bag.find("TFMessage") == std::string::npos ? 0 : size + 4;
  ASSERT_NE(length, 0U);
  bag.replace(length, 4, std::string(4, '\0'));
  expect_drive(read(directory_.write("a.bag", bag)), 20);
}

TEST_F(BagReading, ReadsAPlainChunkAsFarAsItGoes) {
  const std::string bag = ros1_bag({messages_of(drive(kRos1, 20))}, "none");
  const RecordedLog log = read(directory_.write("a.bag", bag.substr(0, bag.size() * 2 / 3)));
  EXPECT_GT(log.scans.size(), 5U);
  EXPECT_LT(log.scans.size(), 20U);
  EXPECT_THAT(remarks_, HasSubstr("a chunk that is cut off"));
}

TEST_F(BagReading, PrefersAWideLidarToADepthCameraOfMoreBeams) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back({stamp, "/camera/scan", "sensor_msgs/msg/LaserScan",
                        laser_scan(kCdr, stamp, std::vector<float>(640, 2.0F), "camera",
                                   {.angle_min = -0.5F, .angle_increment = 1.0F / 640.0F})});
    messages.push_back({stamp, "/scan", "sensor_msgs/msg/LaserScan",
                        laser_scan(kCdr, stamp, std::vector<float>(360, 2.0F), "laser",
                                   {.angle_min = -3.0F, .angle_increment = 0.0174F})});
  }
  EXPECT_EQ(read(directory_.write("a.mcap", mcap({messages}, ""))).header.beams, 360U);
  EXPECT_THAT(remarks_, HasSubstr("scans of /scan only, not of /camera/scan"));
}

TEST_F(BagReading, NamesTheFilesThatTheMetadataDoesNotList) {
  const std::vector<WrittenMessage> messages = messages_of(drive(kCdr, 20));
  write_sqlite_bag(directory_.path() / "a_0.db3", messages);
  write_sqlite_bag(directory_.path() / "a_1.db3", messages);
  directory_.write("metadata.yaml",
                   "rosbag2_bagfile_information:\n  relative_file_paths: [a_0.db3]\n");
  expect_drive(read(directory_.path()), 20);
  EXPECT_EQ(remarks_, "not read, since metadata.yaml does not list them: a_1.db3");
}

TEST_F(BagReading, ReadsABagWithAWriteAheadLogWhereNothingCanBeWritten) {
  const std::filesystem::path path = directory_.path() / "a #1.db3";
  write_sqlite_bag(path, messages_of(drive(kCdr, 20)));
  SQLite::Database(path.string(), SQLite::OPEN_READWRITE).exec("PRAGMA journal_mode=WAL");
  // Where the index of the log would be made.
  std::filesystem::create_directory(path.string() + "-shm");
  expect_drive(read(path), 20);
}

TEST_F(BagReading, SaysThatAFileIsAGitLfsPointer) {
  const auto log = LogReader::open(
      directory_.write("a.bag", "version https://git-lfs.github.com/spec/v1\noid sha256:1\n"));
  ASSERT_FALSE(log);
  EXPECT_THAT(log.error().message, HasSubstr("is a Git LFS pointer and not the file itself"));
}

TEST_F(BagReading, CutsScansThatGoOnBeyondAFullTurn) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 5; ++i) {
    const double stamp = 1.0 + 0.1 * i;
    messages.push_back(
        {stamp, "/scan", "sensor_msgs/msg/LaserScan",
         laser_scan(kCdr, stamp, std::vector<float>(static_cast<std::size_t>(360 + 15 * i), 2.0F),
                    "laser", {.angle_min = -3.14159F, .angle_increment = 0.0174533F})});
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(5));
  for (const LogScan& scan : log.scans) EXPECT_LE(scan.scan.ranges.size(), 362U);
  EXPECT_EQ(faults_.count(), 0U);
}

}  // namespace
}  // namespace cornerfix::evaluation
