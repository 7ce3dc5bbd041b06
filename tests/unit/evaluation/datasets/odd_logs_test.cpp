// Logs as users have them: out of order, of another program, packed, or no logs at all.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/datasets/log_reader.hpp"
#include "support/gzip.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::evaluation {
namespace {

using ::testing::HasSubstr;

constexpr const char* kOddLogHeader =
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
  auto reader = LogReader::open(
      directory_.write("a.jsonl", kOddLogHeader + lines_stamped({2, 1, 4, 3, 6, 5})));
  ASSERT_TRUE(reader.ok());
  const RecordedLog log = read_all(*reader);
  ASSERT_EQ(log.scans.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(log.scans[i].scan.stamp, static_cast<double>(i + 1));
  }
  EXPECT_EQ(remarks(*reader), "3 scans were recorded out of order: they are sorted by stamp");
}

TEST_F(OddLogs, CountsScansThatAreOutOfOrderByFar) {
  auto reader = LogReader::open(directory_.write(
      "a.jsonl", kOddLogHeader + lines_stamped({5, 5.1, 5.2, 5.3, 5.4, 5.5, 5.6, 4})));
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(read_all(*reader).scans.size(), 7U);
  ASSERT_EQ(reader->faults().count(), 1U);
  EXPECT_EQ(reader->faults().first()[0].where, "stamp 4.000000 s");
}

TEST_F(OddLogs, LeavesAScanOutThatRepeatsTheOneBefore) {
  const std::string line = lines_stamped({5});
  auto reader = LogReader::open(directory_.write("a.jsonl", kOddLogHeader + line + line));
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(read_all(*reader).scans.size(), 1U);
  EXPECT_THAT(remarks(*reader), HasSubstr("repeats the scan before"));
}

TEST_F(OddLogs, BeginsANewRunWhenTheStampsJumpAhead) {
  auto reader = LogReader::open(
      directory_.write("a.jsonl", kOddLogHeader + lines_stamped({10, 11, 3700, 3701})));
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
  const auto json = read_log(directory_.write("a.jsonl", "\xef\xbb\xbf" + (kOddLogHeader + lines)));
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
  EXPECT_THAT(message_of("a.jsonl", kOddLogHeader + std::string(R"({"t": 0, "ranges": "none"})")),
              HasSubstr("ranges: expected an array of metres or null"));
  EXPECT_THAT(message_of("a.jsonl", kOddLogHeader + std::string(R"({"t": 0, "odom": {"x": 1}})")),
              HasSubstr("odom: expected [x, y, yaw] or null"));
  EXPECT_THAT(
      message_of("a.jsonl", kOddLogHeader + std::string(R"({"t": 17e17, "ranges": [1, 1, 1]})")),
      HasSubstr("t: expected seconds from -1e12 to 1e12"));
  EXPECT_THAT(message_of("a.jsonl", lines_stamped({0, 1})),
              HasSubstr("header: without angle_min, angle_increment, range_max, expected name, "
                        "beams, angle_min"));
  EXPECT_THAT(message_of("a.jsonl", std::string("\xff\xfe{\0\"\0", 6)),
              HasSubstr("is text in UTF-16, expected UTF-8"));
  EXPECT_THAT(message_of("a.log", "ODOM 0 0 0 0 0 0 1 host 1\nRAWLASER3 0 1\nRAWLASER3 0 1\n"),
              HasSubstr("holds no scan; its messages are ODOM (1), RAWLASER3 (2); expected"));
}

TEST_F(OddLogs, NamesWhatAHeaderDoesNotHave) {
  const std::string no_angle_min = R"({"angle_increment": 1, "range_min": 0, "range_max": 30})"
                                   "\n";
  const auto log = LogReader::open(directory_.write("a.jsonl", no_angle_min + lines_stamped({1})));
  ASSERT_FALSE(log.ok());
  EXPECT_THAT(log.error().message, HasSubstr("header: without angle_min, expected"));
}

TEST_F(OddLogs, ReadsScansWithTheirOwnGeometryWithoutAHeader) {
  std::string lines;
  for (int i = 1; i <= 3; ++i) {
    lines += R"({"angle_min": -1, "angle_increment": 1, "range_min": 0, "range_max": 30, "t": )" +
             std::to_string(i) + R"(, "ranges": [1, 2, 3]})" + "\n";
  }
  const auto log = read_log(directory_.write("a.jsonl", lines));
  ASSERT_TRUE(log.ok()) << log.error().message;
  EXPECT_EQ(log->scans.size(), 3U);
  EXPECT_EQ(log->header.name, "a");
}

TEST_F(OddLogs, MissesTheStampOfAScanThatIsEmpty) {
  const auto log = LogReader::open(directory_.write(
      "a.jsonl",
      R"({"angle_min": 0, "angle_increment": 0.01, "range_min": 0, "range_max": 30, "ranges": []})"));
  ASSERT_FALSE(log.ok());
  EXPECT_THAT(log.error().message, HasSubstr("t: "));
}

TEST_F(OddLogs, TakesTheGeometryOfASecondHeader) {
  const std::string second =
      R"({"name": "b", "beams": 2, "angle_min": 0, "angle_increment": 0.5, "range_max": 9})"
      "\n";
  auto reader = LogReader::open(directory_.write(
      "a.jsonl", kOddLogHeader + lines_stamped({1, 2}) + second + R"({"t": 3, "ranges": [1, 1]})"));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  const RecordedLog log = read_all(*reader);
  EXPECT_EQ(remarks(*reader), "");
  ASSERT_EQ(log.scans.size(), 3U);
  EXPECT_EQ(log.scans[1].scan.angle_increment, 1.5);
  EXPECT_EQ(log.scans[2].scan.angle_increment, 0.5);
}

TEST_F(OddLogs, UsesAScanWhoseOdometryIsNaN) {
  for (const char* odom : {"[NaN, NaN, NaN]", "[1, 2, NaN]", "[null, null, null]"}) {
    auto reader = LogReader::open(directory_.write(
        "a.jsonl", kOddLogHeader + std::string(R"({"t": 1, "ranges": [1, 1, 1], "odom": )") + odom +
                       R"(, "pose": [1, 2, 3]})"));
    ASSERT_TRUE(reader.ok()) << odom << reader.error().message;
    const RecordedLog log = read_all(*reader);
    ASSERT_EQ(log.scans.size(), 1U);
    EXPECT_FALSE(log.scans[0].T_odom_laser);
    EXPECT_TRUE(log.scans[0].T_map_laser);
  }
}

TEST_F(OddLogs, TakesTheConstantThatStandsForNoReturn) {
  std::string lines;
  for (int i = 0; i < 30; ++i) {
    lines += R"({"t": )" + std::to_string(i) + R"(, "ranges": [)";
    for (int beam = 0; beam < 60; ++beam)
      lines += beam % 3 == 0 ? "81.91, " : std::to_string(1 + 0.01 * beam) + ", ";
    lines += "2]}\n";
  }
  const std::string header =
      R"({"angle_min": 0, "angle_increment": 0.05, "range_min": 0, "range_max": 100})"
      "\n";
  auto reader = LogReader::open(directory_.write("a.jsonl", header + lines));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  for (const LogScan& scan : read_all(*reader).scans) {
    EXPECT_EQ(returns_as_points(scan.scan).size(), 41U) << scan.scan.stamp;
  }
  EXPECT_EQ(remarks(*reader),
            "600 ranges of exactly 81.91 m are taken for no returns: none is longer, and hits of a "
            "wall would differ");
}

TEST_F(OddLogs, LeavesOutAScanWhoseStampIsNoTime) {
  auto reader = LogReader::open(directory_.write(
      "a.jsonl", kOddLogHeader + lines_stamped({10, 10.1, 4e8, 10.3, 1, 10.4, 10.5})));
  ASSERT_TRUE(reader.ok());
  const RecordedLog log = read_all(*reader);
  EXPECT_EQ(log.scans.size(), 5U);
  for (const LogScan& scan : log.scans) EXPECT_FALSE(scan.begins_run);
  EXPECT_EQ(reader->faults().scans(), 2U);
  EXPECT_EQ(reader->faults().first()[0].where, "stamp 400000000.000000 s");
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

/// The remarks about a log that was read to its end, or why it cannot be read.
std::string remarks_about(const std::filesystem::path& path, const LogSelection& selection = {}) {
  auto reader = LogReader::open(path, selection);
  if (!reader) return reader.error().message;
  (void)read_all(*reader);
  return remarks(*reader);
}

/// Scans of three ranges, ten a second.
std::string lines_with(const std::string& ranges, int count = 8, double step = 0.1) {
  std::string lines;
  for (int i = 0; i < count; ++i) {
    lines += R"({"t": )" + std::to_string(step * i) + R"(, "ranges": )" + ranges + "}\n";
  }
  return lines;
}

TEST_F(OddLogs, SaysWhyMostScansHaveNoReturn) {
  EXPECT_EQ(
      remarks_about(directory_.write("a.jsonl", kOddLogHeader + lines_with("[4100, 2300, null]"))),
      "8 of 8 scans have no return (range_min 0.1 m, range_max 20 m): of their ranges 67 % "
      "are above, 0 % below, 33 % not finite; the longest is 4100 m; expected metres, are "
      "these millimetres?");
  EXPECT_THAT(
      remarks_about(directory_.write("b.jsonl", kOddLogHeader + lines_with("[0, 0, 0.05]"))),
      HasSubstr("of their ranges 0 % are above, 100 % below, 0 % not finite"));
  EXPECT_EQ(
      remarks_about(directory_.write("c.jsonl", kOddLogHeader + lines_with("[1, null, null]"))),
      "");
}

TEST_F(OddLogs, NamesRangesThatAreFartherThanLidarsSee) {
  const std::string header =
      R"({"angle_min": 0, "angle_increment": 1, "range_min": 50, "range_max": 30000})"
      "\n";
  EXPECT_THAT(remarks_about(directory_.write("a.jsonl", header + lines_with("[4100, 2300, 80]"))),
              HasSubstr("the farthest of the first scan 4100 m: expected metres, are these "
                        "millimetres?"));
}

TEST_F(OddLogs, AsksForTheUnitOfStampsThatAreFarApart) {
  for (const double step : {100.0, 100000.0}) {
    EXPECT_THAT(remarks_about(
                    directory_.write("a.jsonl", kOddLogHeader + lines_with("[1, 1, 1]", 8, step))),
                HasSubstr("most scans are more than 20 s apart"))
        << step;
  }
}

TEST_F(OddLogs, NamesStampsAndPosesThatNoRunHas) {
  const std::vector<std::pair<std::string, std::string>> member_and_message = {
      {R"("t": 1700000000000)",
       "t: expected seconds from -1e12 to 1e12, not 1.7e+12; are these milliseconds?"},
      {R"("t": 1700000000000000000)", "are these micro- or nanoseconds?"},
      {R"("t": 1, "odom": [1e300, 0, 0])", "odom: expected x and y within 1e8 m, not 1e+300 and 0"},
      {R"("t": 1, "pose": [0, -2e8, 0])", "pose: expected x and y within 1e8 m, not 0 and"},
  };
  for (const auto& [member, message] : member_and_message) {
    const std::string line = "{" + member + R"(, "ranges": [1, 1, 1]})";
    EXPECT_THAT(remarks_about(directory_.write("a.jsonl", kOddLogHeader + line)),
                HasSubstr(message));
  }
  EXPECT_THAT(remarks_about(
                  directory_.write("a.log", "FLASER 3 1 2 3 0 0 0 0 0 0 1700000000000 host 1.0\n")),
              HasSubstr("FLASER: stamp: expected seconds"));
}

TEST_F(OddLogs, NamesATimeIncrementThatIsNoTime) {
  const std::string header =
      R"({"angle_min": 0, "angle_increment": 1, "range_min": 0, "range_max": 30, )"
      R"("time_increment": 0.5})"
      "\n";
  EXPECT_EQ(remarks_about(directory_.write("a.jsonl", header + lines_with("[1, 1, 1]"))),
            "time_increment cannot be right in 8 scans, in the first 0.5 s times 3 beams are 1.5 "
            "s, expected at most 1 s: these are used as they are, --scan-time straightens them");
}

TEST_F(OddLogs, TakesTheNumbersThatOtherLanguagesWriteForNoReturn) {
  for (const char* ranges : {"[1, nan, inf]", "[1, -inf, -nan]", R"([1, "NaN", "Infinity"])",
                             R"([1, "inf", "-Infinity"])"}) {
    const auto log = read_log(directory_.write("a.jsonl", kOddLogHeader + lines_with(ranges)));
    ASSERT_TRUE(log.ok()) << log.error().message;
    ASSERT_EQ(log->scans.size(), 8U) << ranges;
    EXPECT_TRUE(log->scans[0].scan.has_return(0));
    EXPECT_TRUE(std::isnan(log->scans[0].scan.ranges[1])) << ranges;
    EXPECT_TRUE(std::isnan(log->scans[0].scan.ranges[2])) << ranges;
  }
}

TEST_F(OddLogs, RefusesAMemberThatIsThereTwice) {
  EXPECT_THAT(
      remarks_about(directory_.write(
          "a.jsonl", kOddLogHeader + std::string(R"({"t": 1, "ranges": [1, 1, 1], "t": 2})"))),
      HasSubstr("t: there twice, expected once"));
}

TEST_F(OddLogs, SaysThatEachLineHoldsOneObject) {
  std::string text = kOddLogHeader + lines_with("[1, 1, 1]");
  std::replace(text.begin(), text.end(), '\n', '\r');
  EXPECT_THAT(remarks_about(directory_.write("a.jsonl", text)),
              HasSubstr("expected one object per line, ended by LF"));
}

TEST_F(OddLogs, SaysThatAnArrayIsNoObjectPerLine) {
  EXPECT_THAT(remarks_about(directory_.write("a.jsonl", "[" + lines_with("[1, 1, 1]") + "]")),
              HasSubstr("at line 1, byte 0: expected one object per line"));
}

TEST_F(OddLogs, NamesMembersOfScansThatAreNotRead) {
  std::string lines;
  for (int i = 0; i < 3; ++i) {
    lines += R"({"t": )" + std::to_string(i) +
             R"(, "ranges": [1, 1, 2], "odometry": [0, 0, 0], "intensities": [], "scan_time": 1})"
             "\n";
  }
  EXPECT_EQ(remarks_about(directory_.write("a.jsonl", kOddLogHeader + lines)),
            "members of scans that are not read: odometry; read are t, ranges, odom, pose, lidar, "
            "kf, time_increment, angle_min, angle_increment, range_min and range_max");
}

TEST_F(OddLogs, ReadsTextOfOneKindThatIsNamedAsTheOther) {
  const std::string carmen = "FLASER 2 1 2 0 0 0 0 0 0 1.0 host 1.0\n";
  EXPECT_EQ(
      read_log(directory_.write("a.log", kOddLogHeader + lines_stamped({1, 2})))->scans.size(), 2U);
  EXPECT_EQ(read_log(directory_.write("a.jsonl", carmen))->scans.size(), 1U);
}

TEST_F(OddLogs, RefusesAPipe) {
  const std::filesystem::path pipe = directory_.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(LogReader::open(pipe).error().message,
              HasSubstr("is no file but a pipe or a device"));
  EXPECT_EQ(LogReader::open("/dev/null").error().field, "/dev/null");
}

TEST_F(OddLogs, SaysThatAFileIsPackedTwice) {
  const std::string packed = testing::gzipped(testing::gzipped(kOddLogHeader));
  EXPECT_THAT(remarks_about(directory_.write("a.jsonl.gz", packed)),
              HasSubstr("is packed with gzip twice"));
}

/// Ten scans a second along an odometry of so many units per scan.
std::string lines_along(double step, double turn) {
  std::string lines;
  for (int i = 0; i < 40; ++i) {
    lines += R"({"t": )" + std::to_string(0.1 * i) + R"(, "ranges": [1, 2, )" +
             std::to_string(3 + i) + R"(], "odom": [)" + std::to_string(step * i) + ", 0, " +
             std::to_string(i < 30 ? 0.0 : turn * (i - 30)) + "]}\n";
  }
  return lines;
}

TEST_F(OddLogs, AsksForTheUnitOfOdometryThatIsTooFast) {
  const auto remarks_on = [&](double step, double turn) {
    return remarks_about(directory_.write("a.jsonl", kOddLogHeader + lines_along(step, turn)));
  };
  EXPECT_EQ(remarks_on(0.05, 0.05), "");
  EXPECT_EQ(remarks_on(50.0, 0.05),
            "the odometry moves faster than 10 m/s or turns faster than 10 rad/s in 100 % of the "
            "scans, first 50 m and 0 rad in 0.1 s: expected metres and radians, are these "
            "millimetres or degrees?");
  EXPECT_THAT(remarks_on(0.05, 2.5), HasSubstr("in 23 % of the scans, first 0.05 m and 2.5 rad"));
}

TEST_F(OddLogs, TakesTheScansOfOneNamedLidar) {
  std::string lines;
  for (int i = 0; i < 6; ++i) {
    lines += R"({"t": )" + std::to_string(i) + R"(, "ranges": [1, 1, )" + std::to_string(i + 1) +
             R"(], "lidar": ")" + (i % 3 == 0 ? "front" : "rear") + "\"}\n";
  }
  const auto path = directory_.write("a.jsonl", kOddLogHeader + lines);
  auto front = LogReader::open(path);
  ASSERT_TRUE(front.ok());
  EXPECT_EQ(read_all(*front).scans.size(), 2U);
  EXPECT_EQ(remarks(*front), "scans of front only, not of rear; --lidar chooses");
  auto rear = LogReader::open(path, {.lidar = "rear"});
  ASSERT_TRUE(rear.ok());
  EXPECT_EQ(read_all(*rear).scans.size(), 4U);
  EXPECT_EQ(remarks_about(path, {.lidar = "side"}),
            "holds no scan of side; its scans are of front (2), rear (4)");
  EXPECT_EQ(remarks_about(directory_.write("b.jsonl", kOddLogHeader + lines_with("[1, 1, 1]")),
                          {.lidar = "front"}),
            "holds no scan of front; its scans are of a lidar without a name (8)");
}

TEST_F(OddLogs, RefusesToChooseTheOdometryOfALogThatHasOne) {
  EXPECT_THAT(remarks_about(directory_.write("a.jsonl", kOddLogHeader + lines_with("[1, 1, 1]")),
                            {.odometry = "/odom"}),
              HasSubstr("/odom can be chosen in bags only (--odom)"));
}

TEST_F(OddLogs, NamesTheCarmenWordThatIsNoRange) {
  EXPECT_THAT(
      remarks_about(directory_.write("a.log", "FLASER 3 1,5 2,5 3,5 0 0 0 0 0 0 1 host 1\n")),
      HasSubstr("FLASER: expected 3 ranges in metres, with a point; at range 0 \"1,5\" is none"));
}

TEST_F(OddLogs, RefusesCarmenScansOfMoreRangesThanTheyCount) {
  EXPECT_THAT(remarks_about(directory_.write("a.log", "FLASER 3 1 2 3 4 0 0 0 0 0 0 1 host 1\n")),
              HasSubstr("FLASER: 10 words behind 3 ranges, expected at most 9"));
}

TEST_F(OddLogs, TakesNanAndInfOfACarmenLogForNoReturn) {
  const auto log = read_log(directory_.write("a.log", "FLASER 3 nan inf 3 0 0 0 0 0 0 1 host 1\n"));
  ASSERT_TRUE(log.ok()) << log.error().message;
  EXPECT_FALSE(log->scans[0].scan.has_return(0));
  EXPECT_FALSE(log->scans[0].scan.has_return(1));
  EXPECT_TRUE(log->scans[0].scan.has_return(2));
}

TEST_F(OddLogs, NamesTheFieldOfViewThatDoesNotFitTheBeams) {
  EXPECT_THAT(
      remarks_about(directory_.write(
          "a.log", "ROBOTLASER1 0 -1.5 3 0.2 30 0.01 0 4 1 1 1 1 0 0 0 0 0 0 0 0 0 0 0 0 1 h 1\n")),
      HasSubstr("angle_max does not fit in 1 scans, in the first it is 1.5 rad, where "
                "angle_min -1.5, angle_increment 0.2 and 4 beams end at -0.9 rad"));
}

TEST_F(OddLogs, NamesTheFieldOfViewThatItAssumes) {
  const auto remarks_of = [&](const std::string& head, int beams) {
    std::string line = "FLASER " + std::to_string(beams);
    for (int beam = 0; beam < beams; ++beam) line += " " + std::to_string(1.0 + 0.01 * beam);
    return remarks_about(directory_.write("a.log", head + line + " 0 0 0 0 0 0 1 host 1\n"));
  };
  EXPECT_THAT(remarks_of("", 1081), HasSubstr("FLASER has no angles: its 1081 beams are taken for "
                                              "half a turn; a line PARAM laser_front_laser_fov"));
  EXPECT_EQ(remarks_of("PARAM laser_front_laser_fov 270\n", 1081), "");
  for (const int of_a_sick : {180, 181, 360, 361, 720, 721})
    EXPECT_EQ(remarks_of("", of_a_sick), "");
}

TEST_F(OddLogs, NamesTheCarmenMessagesThatAreNotTaken) {
  EXPECT_EQ(remarks_about(directory_.write("a.log",
                                           "FLASER 3 1 2 3 0 0 0 0 0 0 1 host 1\n"
                                           "RLASER 3 1 2 3 0 0 0 0 0 0 1 host 1\n")),
            "scans of FLASER only, not of RLASER; --lidar chooses");
}

}  // namespace
}  // namespace cornerfix::evaluation
