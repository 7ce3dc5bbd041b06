// Logs as users have them: out of order, of another program, packed, or no logs at all.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "evaluation/datasets/log_reader.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::evaluation {
namespace {

using ::testing::HasSubstr;

constexpr const char* kHeader =
    R"({"name": "office", "beams": 3, "angle_min": -1.5, "angle_increment": 1.5, )"
    R"("range_min": 0.1, "range_max": 20.0})"
    "\n";

class OddLogs : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
};

/// A line per stamp; the last range counts the lines.
std::string lines_stamped(const std::vector<double>& stamps) {
  std::string lines;
  int count = 0;
  for (const double stamp : stamps) {
    lines += R"({"t": )" + std::to_string(stamp) + R"(, "ranges": [1, 1, )" +
             std::to_string(++count) + "]}\n";
  }
  return lines;
}

TEST_F(OddLogs, SortsScansThatWereRecordedALittleOutOfOrder) {
  auto reader =
      LogReader::open(directory_.write("a.jsonl", kHeader + lines_stamped({2, 1, 4, 3, 6, 5})));
  ASSERT_TRUE(reader.ok());
  const RecordedLog log = read_all(*reader);
  ASSERT_EQ(log.scans.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(log.scans[i].scan.stamp, static_cast<double>(i + 1));
  }
  EXPECT_EQ(remarks(*reader), "3 scans were recorded out of order: they are sorted by stamp");
}

TEST_F(OddLogs, CountsScansThatAreOutOfOrderByFar) {
  auto reader = LogReader::open(
      directory_.write("a.jsonl", kHeader + lines_stamped({5, 5.1, 5.2, 5.3, 5.4, 5.5, 5.6, 4})));
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(read_all(*reader).scans.size(), 7U);
  ASSERT_EQ(reader->faults().count(), 1U);
  EXPECT_EQ(reader->faults().first()[0].where, "stamp 4.000000 s");
}

TEST_F(OddLogs, LeavesAScanOutThatRepeatsTheOneBefore) {
  const std::string line = lines_stamped({5});
  auto reader = LogReader::open(directory_.write("a.jsonl", kHeader + line + line));
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(read_all(*reader).scans.size(), 1U);
  EXPECT_THAT(remarks(*reader), HasSubstr("repeats the scan before"));
}

TEST_F(OddLogs, BeginsANewRunWhenTheStampsJumpAhead) {
  auto reader =
      LogReader::open(directory_.write("a.jsonl", kHeader + lines_stamped({10, 11, 3700, 3701})));
  ASSERT_TRUE(reader.ok());
  const RecordedLog log = read_all(*reader);
  ASSERT_EQ(log.scans.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(log.scans[i].begins_run, i == 2);
  EXPECT_EQ(log.scans[2].scan.stamp, 3700.0);
  EXPECT_EQ(remarks(*reader),
            "the stamps jump ahead 1 times, first by 3689.000000 s to 3700.000000 s: a new run "
            "begins there");
}

TEST_F(OddLogs, TakesTheNanAndInfinityThatPythonWritesForNoReturn) {
  auto reader = LogReader::open(directory_.write(
      "a.jsonl",
      R"({"name": "a", "beams": 3, "angle_min": -1, "angle_increment": 1, "range_min": 0, )"
      R"("range_max": Infinity})"
      "\n"
      R"({"t": 0, "ranges": [NaN, 2.5, Infinity], "odom": [1, 2, 3]})"
      "\n"
      R"({"t": 1, "ranges": [-Infinity, 1, NaN], "pose": [1, 2, 3]})"));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  const RecordedLog log = read_all(*reader);
  EXPECT_EQ(remarks(*reader), "");
  ASSERT_EQ(log.scans.size(), 2U);
  EXPECT_TRUE(std::isinf(log.scans[0].scan.range_max));
  for (const std::size_t beam : {0U, 2U}) {
    EXPECT_FALSE(log.scans[0].scan.has_return(beam));
    EXPECT_FALSE(log.scans[1].scan.has_return(beam));
  }
  EXPECT_EQ(log.scans[0].scan.ranges[1], 2.5F);
  EXPECT_TRUE(log.scans[0].T_odom_laser);
  EXPECT_TRUE(log.scans[1].T_map_laser);
}

TEST_F(OddLogs, PassesOverAByteOrderMark) {
  const std::string lines = lines_stamped({0, 1});
  const auto json = read_log(directory_.write("a.jsonl", "\xef\xbb\xbf" + (kHeader + lines)));
  ASSERT_TRUE(json.ok()) << json.error().message;
  EXPECT_EQ(json->scans.size(), 2U);
  const auto carmen = read_log(directory_.write("a.log",
                                                "\xef\xbb\xbf"
                                                "FLASER 3 1 2 3 0 0 0 0 0 0 1.0 host 1.0\n"));
  ASSERT_TRUE(carmen.ok()) << carmen.error().message;
  EXPECT_EQ(carmen->scans.size(), 1U);
}

TEST_F(OddLogs, NamesWhatIsExpectedOfAWrongLine) {
  const auto message_of = [&](const std::string& name, const std::string& text) {
    const auto log = LogReader::open(directory_.write(name, text));
    return log.ok() ? "" : log.error().message;
  };
  EXPECT_THAT(message_of("a.jsonl", kHeader + std::string(R"({"t": 0, "ranges": "none"})")),
              HasSubstr("ranges: expected an array of metres or null"));
  EXPECT_THAT(message_of("a.jsonl", kHeader + std::string(R"({"t": 0, "odom": {"x": 1}})")),
              HasSubstr("odom: expected [x, y, yaw] or null"));
  EXPECT_THAT(message_of("a.jsonl", kHeader + std::string(R"({"t": 17e17, "ranges": [1, 1, 1]})")),
              HasSubstr("t: expected seconds from -1e12 to 1e12"));
  EXPECT_THAT(message_of("a.jsonl", lines_stamped({0, 1})),
              HasSubstr("header: expected name, beams, angle_min"));
  EXPECT_THAT(message_of("a.jsonl", std::string("\xff\xfe{\0\"\0", 6)),
              HasSubstr("is text in UTF-16, expected UTF-8"));
  EXPECT_THAT(message_of("a.log", "ODOM 0 0 0 0 0 0 1 host 1\nRAWLASER3 0 1\nRAWLASER3 0 1\n"),
              HasSubstr("holds no scan; its messages are ODOM (1), RAWLASER3 (2); expected"));
}

TEST_F(OddLogs, NamesWhatAFileIsThatMustBeUnpacked) {
  const auto message_of = [&](const std::string& name, const std::string& text) {
    return LogReader::open(directory_.write(name, text)).error().message;
  };
  EXPECT_EQ(message_of("a.jsonl", ""), "is empty");
  EXPECT_EQ(message_of("a.jsonl.bz2", "BZh91AY"), "is packed with bzip2: unpack it first");
  EXPECT_EQ(message_of("a.jsonl.xz", std::string("\xfd\x37zXZ\0", 6)),
            "is packed with xz: unpack it first");
  EXPECT_EQ(message_of("a.zip", "PK\x03\x04"), "is packed with zip: unpack it first");
  EXPECT_EQ(message_of("a.tar.gz", "\x1f\x8b"), "is an archive: unpack it first");
}

}  // namespace
}  // namespace cornerfix::evaluation
