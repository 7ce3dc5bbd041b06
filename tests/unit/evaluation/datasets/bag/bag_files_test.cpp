// Bags as they lie: split, packed, renamed, out of order, cut off.
#include "support/gzip.hpp"
#include "unit/evaluation/datasets/bag/bag_reading.hpp"

#include <algorithm>
#include <functional>

namespace cornerfix::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

/// A run in files of a few messages each: "drive_0.db3" and so on.
void write_split(const std::filesystem::path& directory, std::size_t scans, std::size_t files) {
  const std::vector<WrittenMessage> messages = messages_of(drive(kCdr, scans));
  const std::size_t size = messages.size() / files + 1;
  for (std::size_t i = 0; i * size < messages.size(); ++i) {
    const auto begin = messages.begin() + static_cast<std::ptrdiff_t>(i * size);
    const auto end =
        messages.begin() + static_cast<std::ptrdiff_t>(std::min(messages.size(), (i + 1) * size));
    write_sqlite_bag(directory / ("drive_" + std::to_string(i) + ".db3"), {begin, end});
  }
}

TEST_F(BagReading, ReadsTheFilesOfADirectoryByName) {
  write_split(directory_.path(), 40, 12);
  expect_drive(read(directory_.path()), 40);
  EXPECT_EQ(remarks_, "");
}

TEST_F(BagReading, ReadsTheFilesThatTheMetadataListsInTheirOrder) {
  write_split(directory_.path(), 20, 2);
  std::filesystem::rename(directory_.path() / "drive_0.db3", directory_.path() / "z.db3");
  directory_.write("metadata.yaml",
                   "rosbag2_bagfile_information:\n  relative_file_paths:\n    - drive/z.db3\n"
                   "    - drive_1.db3\n    - drive_2.db3\n");
  expect_drive(read(directory_.path()), 20);
  EXPECT_EQ(remarks_, "drive_2.db3, listed in metadata.yaml, is missing");
}

TEST_F(BagReading, ReadsADirectoryOfPackedFiles) {
  const auto chunks = drive(kCdr, 20);
  const std::size_t half = chunks.size() / 2;
  const std::vector<std::vector<WrittenMessage>> first(chunks.begin(), chunks.begin() + half);
  const std::vector<std::vector<WrittenMessage>> second(chunks.begin() + half, chunks.end());
  directory_.write("drive_0.mcap.zstd", zstd_packed(mcap(first, "")));
  directory_.write("drive_1.mcap.zstd", zstd_packed(mcap(second, "lz4")));
  directory_.write("metadata.yaml",
                   "rosbag2_bagfile_information:\n  relative_file_paths: [drive_0.mcap, "
                   "drive_1.mcap]\n  compression_format: zstd\n  compression_mode: FILE\n");
  expect_drive(read(directory_.path()), 20);
  EXPECT_EQ(remarks_, "");
}

TEST_F(BagReading, ReadsPackedMessages) {
  auto chunks = drive(kCdr, 20);
  for (auto& chunk : chunks) {
    for (WrittenMessage& message : chunk) message.bytes = zstd_packed(message.bytes);
  }
  expect_drive(read(directory_.write("drive.mcap", mcap(chunks, ""))), 20);
  const auto path = directory_.path() / "drive_0.db3";
  write_sqlite_bag(path, messages_of(chunks));
  expect_drive(read(path), 20);
  chunks[5].back().bytes.resize(20);
  EXPECT_THAT(read(directory_.write("drive.mcap", mcap(chunks, ""))).scans, SizeIs(19));
  EXPECT_EQ(faults_.count(), 1U);
}

TEST_F(BagReading, SaysWhatIsWrongWithAPackedFile) {
  const std::string packed = zstd_packed(mcap(drive(kCdr, 20), ""));
  const auto cut =
      LogReader::open(directory_.write("a.mcap.zstd", packed.substr(0, packed.size() - 10)));
  EXPECT_THAT(cut.error().message, HasSubstr("the zstd file is cut off"));
  const auto text = LogReader::open(directory_.write("a.jsonl.zstd", zstd_packed("{}")));
  EXPECT_THAT(
      text.error().message,
      HasSubstr("is packed with zstd and holds no bag (.bag, .mcap, .db3): unpack it first"));
  EXPECT_EQ(text.error().field, (directory_.path() / "a.jsonl.zstd").string());
}

/// Topic after topic, as scripts write data sets.
std::vector<WrittenMessage> by_topic(std::vector<WrittenMessage> messages) {
  std::ranges::stable_sort(messages, std::ranges::greater(), &WrittenMessage::topic);
  return messages;
}

TEST_F(BagReading, SortsABagThatWasWrittenTopicByTopic) {
  const std::vector<WrittenMessage> ros1 = by_topic(messages_of(drive(kRos1, 40)));
  expect_drive(read(directory_.write("a.bag", ros1_bag({ros1}, "none"))), 40);
  EXPECT_EQ(remarks_, "the messages are not in the order of their time: they are sorted");
  const std::vector<WrittenMessage> ros2 = by_topic(messages_of(drive(kCdr, 40)));
  expect_drive(read(directory_.write("a.mcap", mcap({ros2}, "zstd"))), 40);
  const auto path = directory_.path() / "a.db3";
  write_sqlite_bag(path, ros2);
  expect_drive(read(path), 40);
}

TEST_F(BagReading, TakesStaticTransformsThatWereRecordedLate) {
  std::vector<WrittenMessage> messages = messages_of(drive(kCdr, 30));
  std::ranges::rotate(messages, messages.begin() + 1);
  messages.back().received = 103.0;
  expect_drive(read(directory_.write("a.mcap", mcap({messages}, ""))), 30);
  EXPECT_EQ(remarks_, "");
}

TEST_F(BagReading, ReadsBagsPackedWithGzip) {
  expect_drive(
      read(directory_.write("a.bag.gz", testing::gzipped(ros1_bag(drive(kRos1, 5), "none")))), 5);
  expect_drive(read(directory_.write("a.mcap.gz", testing::gzipped(mcap(drive(kCdr, 5), "")))), 5);
}

TEST_F(BagReading, ReadsTheDirectoryOfItsMetadata) {
  write_split(directory_.path(), 20, 2);
  directory_.write("metadata.yaml",
                   "rosbag2_bagfile_information:\n  relative_file_paths: [drive_0.db3, "
                   "drive_1.db3]\n");
  expect_drive(read(directory_.path() / "metadata.yaml"), 20);
}

TEST_F(BagReading, ReadsARenamedBagByTheNamesOfItsFiles) {
  write_split(directory_.path(), 20, 2);
  directory_.write("metadata.yaml",
                   "rosbag2_bagfile_information:\n  relative_file_paths: [gone_0.db3]\n");
  expect_drive(read(directory_.path()), 20);
  EXPECT_EQ(remarks_,
            "gone_0.db3, listed in metadata.yaml, is missing; all bag files of the directory are "
            "read, by name");
}

TEST_F(BagReading, NamesTheBagInADirectoryAboveIt) {
  std::filesystem::create_directory(directory_.path() / "run");
  write_split(directory_.path() / "run", 3, 1);
  EXPECT_THAT(LogReader::open(directory_.path()).error().message, HasSubstr("run is a bag"));
}

TEST_F(BagReading, NamesAnEncodingThatItCannotRead) {
  std::string bag = mcap(drive(kCdr, 3), "");
  for (std::size_t at = bag.find("cdr"); at != std::string::npos; at = bag.find("cdr", at)) {
    bag.replace(at, 3, "xml");
  }
  const auto log = LogReader::open(directory_.write("a.mcap", bag));
  EXPECT_THAT(log.error().message,
              HasSubstr("/scan (sensor_msgs/msg/LaserScan as xml, 3 messages"));
}

TEST_F(BagReading, NamesTopicsWithoutASchema) {
  std::string bag = mcap(drive(kCdr, 3), "");
  for (std::size_t at = bag.find("sensor_msgs/msg/LaserScan"); at != std::string::npos;
       at = bag.find("sensor_msgs/msg/LaserScan", at + 1)) {
    const std::size_t record = at - 4 - 2 - 8 - 1;
    if (bag[record] == '\x03') bag[record] = '\x0b';  // An index, which is passed over.
  }
  EXPECT_THAT(LogReader::open(directory_.write("a.mcap", bag)).error().message,
              HasSubstr("/scan (without a schema, 3 messages"));
}

TEST_F(BagReading, GivesOdometryWithoutStampsTheTimeOfRecording) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 20; ++i) {
    const double time = 100.0 + 0.1 * i;
    messages.push_back(odometry_message(kCdr, 0.0, 0.1 * i, 0.0, 0.0));
    messages.back().received = time;
    messages.push_back(scan_message(kCdr, 0.0));
    messages.back().received = time + 0.001;
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(20));
  ASSERT_TRUE(log.scans[10].T_odom_laser);
  EXPECT_NEAR(log.scans[10].T_odom_laser->x, 1.001, 1e-6);
}

TEST_F(BagReading, GivesScansWithoutAFrameNoOdometry) {
  auto chunks = drive(kCdr, 5);
  for (auto& chunk : chunks) {
    for (WrittenMessage& message : chunk) {
      if (message.topic != "/scan") continue;
      message.bytes = laser_scan(kCdr, message.received - 0.01, {1.5F, 2.5F}, "");
    }
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap(chunks, "")));
  ASSERT_THAT(log.scans, SizeIs(5));
  for (const LogScan& scan : log.scans) EXPECT_FALSE(scan.T_odom_laser);
  EXPECT_THAT(remarks_, HasSubstr("no odometry for 5 scans without a frame_id"));
}

TEST_F(BagReading, NamesTheShareOfScansThatLackOdometry) {
  auto chunks = drive(kCdr, 20);
  for (std::size_t i = 10; i < chunks.size(); ++i) chunks[i].erase(chunks[i].begin());
  const RecordedLog log = read(directory_.write("a.mcap", mcap(chunks, "")));
  EXPECT_THAT(log.scans, SizeIs(20));
  EXPECT_TRUE(log.scans[5].T_odom_laser);
  EXPECT_THAT(remarks_, HasSubstr("of 20 scans in the frame laser, stamped 100.050 to 101.950 s"));
}

TEST_F(BagReading, BeginsANewRunWhenTheClockIsSetBack) {
  std::vector<WrittenMessage> messages;
  for (int i = 0; i < 10; ++i) {
    const double stamp = i < 5 ? 10000.0 + 0.1 * i : 6400.0 + 0.1 * i;
    messages.push_back(tf_message(kCdr, stamp, {{"odom", "laser", 0.1 * i, 0.0, 0.0}}));
    messages.push_back(scan_message(kCdr, stamp));
  }
  const RecordedLog log = read(directory_.write("a.mcap", mcap({messages}, "")));
  ASSERT_THAT(log.scans, SizeIs(10));
  EXPECT_EQ(faults_.count(), 0U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(log.scans[i].begins_run, i == 5);
    ASSERT_TRUE(log.scans[i].T_odom_laser) << i;
    EXPECT_NEAR(log.scans[i].T_odom_laser->x, 0.1 * static_cast<double>(i), 1e-6);
  }
  EXPECT_NEAR(log.scans[5].scan.stamp, log.scans[4].scan.stamp + 600.0, 1e-6);
  EXPECT_NEAR(log.scans[6].scan.stamp, log.scans[5].scan.stamp + 0.1, 1e-6);
  EXPECT_THAT(remarks_, HasSubstr("the clock was set back 1 times"));
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
  std::filesystem::create_directory(directory_.path() / "empty");
  EXPECT_THAT(LogReader::open(directory_.path() / "empty").error().message,
              HasSubstr("is a directory without the files of a bag"));
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
}  // namespace cornerfix::evaluation
