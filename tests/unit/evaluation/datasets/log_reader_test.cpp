#include "evaluation/datasets/log_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/gzip.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::evaluation {
namespace {

using ::testing::HasSubstr;

constexpr const char* kHeader =
    R"({"name": "office", "beams": 3, "angle_min": -1.5, "angle_increment": 1.5, )"
    R"("range_min": 0.1, "range_max": 20.0, "license": ["any", {"kind": 1}]})"
    "\n";

class LogReading : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
};

TEST_F(LogReading, TakesGeometryFromTheHeader) {
  const auto path = directory_.write(
      "a.jsonl", std::string(kHeader) + R"({"t": 1.5, "ranges": [1, 2.5, null]})" + "\n");
  const auto log = read_log(path);
  ASSERT_TRUE(log.ok()) << log.error().message;
  EXPECT_EQ(log->header.name, "office");
  EXPECT_EQ(log->header.beams, 3U);
  ASSERT_EQ(log->scans.size(), 1U);
  const LaserScan& scan = log->scans[0].scan;
  EXPECT_EQ(scan.stamp, 1.5);
  EXPECT_EQ(scan.angle_min, -1.5);
  EXPECT_EQ(scan.angle_increment, 1.5);
  EXPECT_EQ(scan.range_max, 20.0);
  EXPECT_EQ(scan.ranges[1], 2.5F);
  EXPECT_TRUE(std::isnan(scan.ranges[2]));
}

TEST_F(LogReading, TakesPosesWhereThereAreAny) {
  const auto path = directory_.write(
      "a.jsonl", std::string(kHeader) +
                     R"({"t":0,"ranges":[1,1,1],"odom":[1,2,0.5],"pose":null})"
                     "\n\n"
                     R"({"t":1,"ranges":[1,1,1],"odom":null,"pose":[3,4,-0.5],"kf":1})");
  const auto log = read_log(path);
  ASSERT_TRUE(log.ok()) << log.error().message;
  ASSERT_EQ(log->scans.size(), 2U);
  EXPECT_EQ(log->scans[0].T_odom_laser, (Pose2{1.0, 2.0, 0.5}));
  EXPECT_FALSE(log->scans[0].T_map_laser);
  EXPECT_FALSE(log->scans[0].is_key_scan);
  EXPECT_FALSE(log->scans[1].T_odom_laser);
  EXPECT_EQ(log->scans[1].T_map_laser, (Pose2{3.0, 4.0, -0.5}));
  EXPECT_TRUE(log->scans[1].is_key_scan);
}

TEST_F(LogReading, KeepsEveryNthScanFromTheFirst) {
  std::string text = kHeader;
  for (int i = 0; i < 7; ++i)
    text += R"({"t": )" + std::to_string(i) +
            R"(, "ranges": [1,1,1]})"
            "\n";
  const auto log = read_log(directory_.write("a.jsonl", text), 3);
  ASSERT_TRUE(log.ok());
  ASSERT_EQ(log->scans.size(), 3U);
  EXPECT_EQ(log->scans[1].scan.stamp, 3.0);
}

std::string long_log() {
  std::string text = kHeader;
  for (int i = 0; i < 20000; ++i) {
    text += R"({"t": )" + std::to_string(i) + R"(, "ranges": [1.)" + std::to_string(i * 7919) +
            ",2,3]}\n";
  }
  return text;
}

TEST_F(LogReading, ReadsGzipAsItReadsText) {
  const auto packed = read_log(directory_.write("b.jsonl.gz", testing::gzipped(long_log())));
  const auto plain = read_log(directory_.write("a.jsonl", long_log()));
  ASSERT_TRUE(packed.ok()) << packed.error().message;
  ASSERT_EQ(packed->scans.size(), 20000U);
  EXPECT_EQ(packed->scans[12345].scan.ranges, plain->scans[12345].scan.ranges);
}

TEST_F(LogReading, KeepsWhatATruncatedGzipHoldsAndSaysWhereItEnds) {
  const auto path = directory_.write("cut.jsonl.gz", testing::gzipped(long_log()));
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  auto reader = LogReader::open(path);
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  const std::size_t scans = read_all(*reader).scans.size();
  EXPECT_GT(scans, 1000U);
  EXPECT_LT(scans, 20000U);
  ASSERT_EQ(reader->faults().count(), 1U);
  const LogFault& fault = reader->faults().first()[0];
  EXPECT_EQ(fault.message, "the compressed file ends too early");
  EXPECT_THAT(fault.where, HasSubstr("line " + std::to_string(scans + 2) + ", byte "));
}

TEST_F(LogReading, LeavesBrokenLinesOutAndReportsWhereTheyAre) {
  const std::string good0 = R"({"t": 0, "ranges": [1, 1, 1]})"
                            "\n";
  const std::string good2 = R"({"t": 2, "ranges": [1, 1, 1]})"
                            "\n";
  const std::vector<std::pair<std::string, std::string>> bad_line_and_message = {
      {R"({"t": 1, "ranges": [1, 1]})", "ranges: 2 values, expected 3"},
      {R"({"t": 1, "ranges": []})", "ranges: none, expected metres or null"},
      {R"({"t": 1})", "ranges: none, expected metres or null"},
      {R"({"t": 1, "ranges": [1, 1, "far"]})", "ranges/2: expected metres or null"},
      {R"({"t": 1, "ranges": [1, 1, 1)", ""},
      {R"({"ranges": [1, 1, 1]})", "t: missing, expected seconds"},
      {R"({"t": 1, "ranges": [1, 1, 1], "pose": [1, 2]})", "pose: "},
      {R"({"t": 1, "ranges": [1, 1, 1], "pose": [1, 2, 3, 4]})", "pose: "},
      {R"({"t": 1, "ranges": [1, 1, 1]} {})", "more text behind the object"},
      {"scan", ""},
  };
  for (const auto& [line, message] : bad_line_and_message) {
    auto reader =
        LogReader::open(directory_.write("a.jsonl", kHeader + good0 + line + "\n" + good2));
    ASSERT_TRUE(reader.ok()) << line;
    EXPECT_EQ(read_all(*reader).scans.size(), 2U) << line;
    ASSERT_EQ(reader->faults().count(), 1U) << line;
    const std::size_t offset = std::string(kHeader).size() + good0.size();
    EXPECT_EQ(reader->faults().first()[0].where, "line 3, byte " + std::to_string(offset));
    EXPECT_THAT(reader->faults().first()[0].message, HasSubstr(message)) << line;
    EXPECT_THAT(remarks(*reader), HasSubstr("1 broken record left out, the first at line 3"));
  }
}

TEST_F(LogReading, GivesUpOnAFileOfBrokenLinesOnly) {
  std::string text;
  for (int i = 0; i < 100000; ++i) text += "nonsense\n";
  auto log = LogReader::open(directory_.write("a.jsonl", text));
  ASSERT_FALSE(log.ok());
  EXPECT_THAT(log.error().message, HasSubstr("holds no scan; 100 broken records left out"));
}

TEST_F(LogReading, LeavesScansOutThatNoLidarTakes) {
  auto reader = LogReader::open(directory_.write(
      "a.jsonl",
      R"({"name": "office", "beams": 4, "angle_min": -1, "angle_increment": 4, "range_min": 0.1, "range_max": 9})"
      "\n"
      R"({"t": 1, "ranges": [1, 1, 1, 1]})"));
  ASSERT_FALSE(reader.ok());
  EXPECT_THAT(reader.error().message, HasSubstr("cover more than a full turn"));
}

TEST_F(LogReading, KeepsTheOrderOfScansOfOneStamp) {
  auto reader = LogReader::open(directory_.write("a.jsonl", std::string(kHeader) +
                                                                R"({"t": 5, "ranges": [1,1,1]})"
                                                                "\n"
                                                                R"({"t": 5, "ranges": [1,1,2]})"
                                                                "\n"
                                                                R"({"t": 5, "ranges": [1,1,3]})"
                                                                "\n"
                                                                R"({"t": 6, "ranges": [1,1,4]})"));
  ASSERT_TRUE(reader.ok());
  const RecordedLog log = read_all(*reader);
  ASSERT_EQ(log.scans.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(log.scans[i].scan.ranges[2], static_cast<float>(i + 1));
    EXPECT_TRUE(i == 0 || log.scans[i].scan.stamp > log.scans[i - 1].scan.stamp);
  }
  EXPECT_EQ(log.scans[3].scan.stamp, 6.0);
  EXPECT_THAT(remarks(*reader), HasSubstr("2 scans have the stamp of the scan before"));
}

TEST_F(LogReading, BeginsANewRunWhenTheClockIsSetBack) {
  auto reader = LogReader::open(
      directory_.write("a.jsonl", std::string(kHeader) + R"({"t": 5000, "ranges": [1,1,1]})"
                                                         "\n"
                                                         R"({"t": 1400, "ranges": [1,1,2]})"
                                                         "\n"
                                                         R"({"t": 1401, "ranges": [1,1,3]})"));
  ASSERT_TRUE(reader.ok());
  const RecordedLog log = read_all(*reader);
  ASSERT_EQ(log.scans.size(), 3U);
  EXPECT_FALSE(log.scans[0].begins_run);
  EXPECT_TRUE(log.scans[1].begins_run);
  EXPECT_EQ(log.scans[1].scan.stamp, 5600.0);
  EXPECT_FALSE(log.scans[2].begins_run);
  EXPECT_EQ(log.scans[2].scan.stamp, 5601.0);
  EXPECT_THAT(remarks(*reader), HasSubstr("by 3600.000000 s to 1400.000000 s"));
}

TEST_F(LogReading, ReportsThatMostScansWereLeftOut) {
  const std::string good = R"({"t": 1, "ranges": [1, 1, 1]})"
                           "\n";
  const std::string bad = R"({"t": 2, "ranges": [1, 1]})"
                          "\n";
  auto reader = LogReader::open(directory_.write("a.jsonl", kHeader + good + bad));
  ASSERT_TRUE(reader.ok());
  static_cast<void>(read_all(*reader));
  EXPECT_FALSE(reader->most_scans_lost());
  auto poor = LogReader::open(directory_.write("a.jsonl", kHeader + good + bad + bad));
  ASSERT_TRUE(poor.ok());
  static_cast<void>(read_all(*poor));
  ASSERT_TRUE(poor->most_scans_lost());
  EXPECT_THAT(poor->most_scans_lost()->message,
              HasSubstr("2 of 3 scans were left out; 2 broken records left out, the first at line "
                        "3"));
}

TEST_F(LogReading, TakesTheGeometryThatAScanHasItself) {
  const auto log = read_log(directory_.write(
      "a.jsonl",
      std::string(kHeader) +
          R"({"t": 1, "angle_min": -2, "angle_increment": 0.5, "ranges": [1, 2, 3, 4, 5]})"
          "\n"
          R"({"t": 2, "range_max": null, "ranges": [1, 2, 1000]})"
          "\n"
          R"({"t": 3, "ranges": [1, 2, 3]})"));
  ASSERT_TRUE(log.ok());
  ASSERT_EQ(log->scans.size(), 3U);
  EXPECT_EQ(log->scans[0].scan.angle_min, -2.0);
  EXPECT_EQ(log->scans[0].scan.ranges.size(), 5U);
  EXPECT_TRUE(log->scans[1].scan.has_return(2));
  EXPECT_EQ(log->scans[2].scan.angle_min, log->header.lidar.angle_min);
}

TEST_F(LogReading, StraightensScansByTheirOdometry) {
  const std::string header =
      R"({"angle_min": -1, "angle_increment": 0.5, "range_min": 0.1, "range_max": 9)";
  const std::string scans = R"({"t": 1, "ranges": [1, 1, 1, 1], "odom": [0, 0, 0]})"
                            "\n"
                            R"({"t": 1.4, "ranges": [1, 1, 1, 1], "odom": [0, 0, 0.08]})"
                            "\n"
                            R"({"t": 9, "ranges": [1, 1, 1, 1], "odom": [0, 0, 0.08]})";
  auto reader = LogReader::open(
      directory_.write("a.jsonl", header + R"(, "time_increment": 0.1})" + "\n" + scans));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  const RecordedLog log = read_all(*reader);
  ASSERT_EQ(log.scans.size(), 3U);
  EXPECT_NEAR(log.scans[0].scan.angle_increment, 0.52, 1e-12);
  EXPECT_NEAR(log.scans[1].scan.angle_increment, 0.52, 1e-12);
  EXPECT_EQ(log.scans[2].scan.angle_increment, 0.5);
  EXPECT_THAT(remarks(*reader), HasSubstr("1 scans were taken beam by beam"));
  auto told =
      LogReader::open(directory_.write("a.jsonl", header + "}\n" + scans), {.scan_time = 0.4});
  ASSERT_TRUE(told.ok());
  EXPECT_NEAR(told->next()->scan.angle_increment, 0.52, 1e-12);
}

TEST_F(LogReading, TakesARangeMaxOfNullForNoLimit) {
  const auto log = read_log(directory_.write(
      "a.jsonl", R"({"angle_min": -1, "angle_increment": 1, "range_min": 0.1, "range_max": null})"
                 "\n"
                 R"({"t": 1, "ranges": [1, null, 1000]})"));
  ASSERT_TRUE(log.ok()) << log.error().message;
  EXPECT_TRUE(log->scans.at(0).scan.has_return(2));
  EXPECT_FALSE(log->scans.at(0).scan.has_return(1));
}

TEST_F(LogReading, RefusesAHeaderThatNoLidarCanHave) {
  const auto log = read_log(directory_.write(
      "a.jsonl", R"({"name": "x", "beams": 3, "angle_min": 0, "angle_increment": 0.1, )"
                 R"("range_max": 0})"
                 "\n"));
  ASSERT_FALSE(log.ok());
  EXPECT_THAT(log.error().message, HasSubstr("line 1, byte 0: header: range_max"));
}

TEST_F(LogReading, NamesTheMemberOfALineThatHasAnotherType) {
  const auto message = [&](const std::string& header, const std::string& line) {
    const auto log = read_log(directory_.write("a.jsonl", header + "\n" + line + "\n"));
    return log.ok() ? std::string("read") : log.error().message;
  };
  EXPECT_THAT(message(kHeader, R"({"t": 1, "odom": [0, 0, 0, 1], "ranges": [1, 2, 3]})"),
              HasSubstr("odom: expected [x, y, yaw] or null"));
  EXPECT_THAT(message("[1, 2]", ""), HasSubstr("expected one object per line"));
  EXPECT_THAT(message(R"({"angle_min": 0, "angle_increment": 0, "range_min": 0, "range_max": 9})",
                      R"({"t": 1, "ranges": [1, 2, 3]})"),
              HasSubstr("header: angle_increment"));
}

TEST_F(LogReading, RefusesFilesThatHoldNoRun) {
  EXPECT_EQ(read_log(directory_.write("a.jsonl", kHeader)).error().message, "holds no scan");
  EXPECT_EQ(read_log(directory_.write("a.bag", "nonsense")).error().code,
            ErrorCode::kInvalidArgument);
  EXPECT_EQ(read_log(directory_.path() / "gone.jsonl").error().code, ErrorCode::kNotFound);
}

TEST_F(LogReading, ReadsCarmenLaserMessagesAndSkipsTheRest) {
  const auto path =
      directory_.write("drive.clf",
                       "# comment\nPARAM robot_frontlaser_offset 0.0\n"
                       "ODOM 0 0 0 0 0 0 1.0 host 1.0\n"
                       "FLASER 4 1.0 2.0 3.0 81.9 0.5 0.6 0.7 0.1 0.2 0.3 976.25 host 0.9\n"
                       "FLASER 4 1.5 2.5 3.5 81.9 1.5 0.6 0.7 1.1 0.2 0.3 977.25 host 1.9\n");
  const auto log = read_log(path);
  ASSERT_TRUE(log.ok()) << log.error().message;
  EXPECT_EQ(log->header.name, "drive");
  EXPECT_NEAR(log->header.lidar.angle_min, -std::numbers::pi / 2.0, 1e-12);
  EXPECT_NEAR(log->header.lidar.angle_increment, std::numbers::pi / 4.0, 1e-12);
  ASSERT_EQ(log->scans.size(), 2U);
  const LogScan& scan = log->scans[1];
  EXPECT_EQ(scan.scan.stamp, 977.25);
  EXPECT_EQ(scan.scan.ranges[2], 3.5F);
  EXPECT_FALSE(scan.scan.has_return(3));
  EXPECT_EQ(scan.T_map_laser, (Pose2{1.5, 0.6, 0.7}));
  EXPECT_EQ(scan.T_odom_laser, (Pose2{1.1, 0.2, 0.3}));
}

TEST_F(LogReading, GivesAnOddNumberOfCarmenBeamsBothEndsOfTheHalfTurn) {
  const auto log =
      read_log(directory_.write("drive.log", "FLASER 3 1 2 3 0 0 0 0 0 0 1.0 host 1.0\n"));
  ASSERT_TRUE(log.ok()) << log.error().message;
  EXPECT_NEAR(log->scans[0].scan.bearing(2), std::numbers::pi / 2.0, 1e-12);
}

TEST_F(LogReading, LeavesABrokenCarmenMessageOutAndReportsWhereItIs) {
  auto reader = LogReader::open(
      directory_.write("drive.gfs",
                       "# start\nFLASER 3 1 2 3 0 0 0 0 0 0 1.0 host 1.0\nFLASER 3 1 2\n"
                       "FLASER 99999999999 1 2 3\nFLASER 3 1 2 3 0 0 0 0 0 0 2.0 host 1.0\n"));
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ(read_all(*reader).scans.size(), 2U);
  ASSERT_EQ(reader->faults().count(), 2U);
  EXPECT_EQ(reader->faults().first()[0].where, "line 3, byte 48");
  EXPECT_EQ(reader->faults().first()[0].message,
            "FLASER: expected 3 ranges in metres, with a point; at range 2 the line ends");
  EXPECT_EQ(reader->faults().first()[1].message,
            "FLASER: expected a number of beams from 2 to 20000");
}

TEST_F(LogReading, TakesACarmenPoseThatOnlyRepeatsTheOdometryForNoReference) {
  const auto log = read_log(directory_.write("drive.log",
                                             "PARAM robot_frontlaser_offset 0.5 host 0\n"
                                             "FLASER 2 1 2 1.5 2 0 1 2 0 1.0 host 1.0\n"
                                             "FLASER 2 1 2 1.8 2 0 1.1 2 0 2.0 host 1.0\n"));
  ASSERT_TRUE(log.ok());
  EXPECT_FALSE(log->scans[0].T_map_laser);
  EXPECT_EQ(log->scans[0].T_odom_laser, (Pose2{1.5, 2.0, 0.0}));
  EXPECT_EQ(log->scans[1].T_map_laser, (Pose2{1.8, 2.0, 0.0}));
}

TEST_F(LogReading, TakesOneOfTheLasersOfACarmenLog) {
  const auto path = directory_.write("drive.log",
                                     "PARAM robot_rearlaser_offset -0.3 host 0\n"
                                     "FLASER 2 1 2 9 9 0 1 2 0 1.0 host 1.0\n"
                                     "RLASER 2 3 4 8 8 0 1 2 0 1.5 host 1.0\n");
  const auto front = read_log(path);
  ASSERT_TRUE(front.ok());
  ASSERT_EQ(front->scans.size(), 1U);
  EXPECT_EQ(front->scans[0].scan.ranges[0], 1.0F);
  auto reader = LogReader::open(path, {.lidar = "RLASER"});
  ASSERT_TRUE(reader.ok());
  const RecordedLog rear = read_all(*reader);
  ASSERT_EQ(rear.scans.size(), 1U);
  EXPECT_EQ(rear.scans[0].scan.ranges[0], 3.0F);
  EXPECT_NEAR(rear.scans[0].T_odom_laser->x, 0.7, 1e-12);
  EXPECT_NEAR(rear.scans[0].T_odom_laser->yaw, std::numbers::pi, 1e-12);
}

// laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode
constexpr const char* kLaserConfig = "0 -1.5 3.0 1.5 50.0 0.01 0 ";

TEST_F(LogReading, ReadsNewCarmenLaserMessagesWithAndWithoutRemissions) {
  const std::string config = kLaserConfig;
  const auto log = read_log(directory_.write(
      "drive.log", "ROBOTLASER1 " + config +
                       "3 1 2 50.0 2 7 8 1.5 0.6 0.7 1 0.6 0.7 0.1 0 0.5 0.5 1e4 10.5 host 0.1\n"
                       "ROBOTLASER1 " +
                       config + "3 1 2 3 1.6 0.6 0.7 1 0.6 0.7 0.1 0 0.5 0.5 11.5 host 0.2\n"));
  ASSERT_TRUE(log.ok()) << log.error().message;
  ASSERT_EQ(log->scans.size(), 2U);
  EXPECT_EQ(log->header.lidar.angle_min, -1.5);
  EXPECT_EQ(log->header.lidar.angle_increment, 1.5);
  EXPECT_FALSE(log->scans[0].scan.has_return(2));  // At the maximum range.
  EXPECT_EQ(log->scans[0].scan.stamp, 10.5);
  EXPECT_EQ(log->scans[1].scan.stamp, 11.5);
  EXPECT_EQ(log->scans[1].T_odom_laser, (Pose2{1.6, 0.6, 0.7}));
  EXPECT_FALSE(log->scans[1].T_map_laser);
}

TEST_F(LogReading, GivesARawCarmenLaserTheOdometryOfItsTime) {
  const auto log =
      read_log(directory_.write("drive.log",
                                "PARAM robot_frontlaser_offset 0.2 host 0\n"
                                "ODOM 1.0 2.0 0.0 0.5 0.0 0.0 10.0 host 0.1\n"
                                "RAWLASER1 " +
                                    std::string(kLaserConfig) + "3 1 2 3 0 10.2 host 0.2\n"));
  ASSERT_TRUE(log.ok()) << log.error().message;
  ASSERT_TRUE(log->scans[0].T_odom_laser);
  EXPECT_NEAR(log->scans[0].T_odom_laser->x, 1.0 + 0.5 * 0.2 + 0.2, 1e-9);
}

TEST_F(LogReading, ReadsCarmenScansWhoseNumberOfBeamsVaries) {
  const auto log = read_log(directory_.write("drive.log",
                                             "FLASER 3 1 2 3 0 0 0 0 0 0 1.0 host 1.0\n"
                                             "FLASER 5 1 2 3 4 5 0 0 0 0 0 0 2.0 host 2.0\n"));
  ASSERT_TRUE(log.ok());
  ASSERT_EQ(log->scans.size(), 2U);
  EXPECT_NEAR(log->scans[1].scan.bearing(4), std::numbers::pi / 2.0, 1e-12);
}

TEST_F(LogReading, ReadsCarmenStampsOfSixDigits) {
  const auto log =
      read_log(directory_.write("drive.log",
                                "FLASER 3 1 2 3 0 0 0 0.0 0 0 1.13486e+09 host 1.13486e+09\n"
                                "FLASER 3 1 2 4 0 0 0 0.1 0 0 1.13486e+09 host 1.13486e+09\n"
                                "FLASER 3 1 2 5 0 0 0 0.2 0 0 1.13486e+09 host 1.13486e+09\n"));
  ASSERT_TRUE(log.ok());
  ASSERT_EQ(log->scans.size(), 3U);
  EXPECT_NEAR(log->scans[2].scan.stamp, 1134860000.02, 1e-6);
  EXPECT_EQ(log->scans[2].T_odom_laser->x, 0.2);
}

TEST_F(LogReading, ReadsTheLogsOfGMapping) {
  const auto log = read_log(directory_.write("drive.gfs",
                                             "PARAM xmin -100\n"
                                             "ODOM 1.0 2.0 0.5 10.0\n"
                                             "ODO_UPDATE 1 4.0 5.0 0.1 0.0 10.0\n"
                                             "LASER_READING 3 1 2 3 0 0 0 10.0\n"
                                             "SM_UPDATE 2 4.0 5.0 0.1 -9.0 6.0 7.0 0.2 -8.0 10.0\n"
                                             "NEFF 1.0\n"
                                             "ODOM 1.1 2.0 0.5 10.1\n"
                                             "LASER_READING 3 1 2 81.9 0 0 0 10.1\n"
                                             "ODOM 1.2 2.0 0.5 10.2\n"
                                             "LASER_READING 3 1 2 5 0 0 0 10.2\n"));
  ASSERT_TRUE(log.ok());
  ASSERT_EQ(log->scans.size(), 3U);
  EXPECT_EQ(log->scans[0].T_odom_laser, (Pose2{1.0, 2.0, 0.5}));
  EXPECT_EQ(log->scans[0].T_map_laser, (Pose2{6.0, 7.0, 0.2}));
  EXPECT_NEAR(log->scans[0].scan.bearing(0), -std::numbers::pi / 2.0, 1e-12);
  EXPECT_EQ(log->scans[1].T_odom_laser, (Pose2{1.1, 2.0, 0.5}));
  EXPECT_FALSE(log->scans[1].T_map_laser);
  EXPECT_FALSE(log->scans[1].scan.has_return(2));
  EXPECT_EQ(log->scans[2].scan.stamp, 10.2);
}

TEST_F(LogReading, TakesFieldOfViewAndRangeOfACarmenLogFromItsParameters) {
  const auto log = read_log(directory_.write("drive.log",
                                             "PARAM laser_front_laser_fov 90.0 host 0\n"
                                             "PARAM robot_front_laser_max 50.0 host 0\n"
                                             "FLASER 3 1 50.0 3 0 0 0 0 0 1 1.0 host 1.0\n"));
  ASSERT_TRUE(log.ok());
  EXPECT_NEAR(log->scans[0].scan.bearing(0), -std::numbers::pi / 4.0, 1e-12);
  EXPECT_NEAR(log->scans[0].scan.bearing(2), std::numbers::pi / 4.0, 1e-12);
  EXPECT_FALSE(log->scans[0].scan.has_return(1));
}

TEST_F(LogReading, LeavesCarmenScansOutThatNoLidarTakes) {
  const auto log = read_log(directory_.write(
      "drive.log",
      "ROBOTLASER1 0 -1.5 3.0 4.0 50.0 0.01 0 4 1 2 3 4 0 0 0 0 0 0 0 0 0 0 0 0 11.5 host 0.2\n"));
  ASSERT_FALSE(log.ok());
  EXPECT_THAT(log.error().message, HasSubstr("cover more than a full turn"));
}

TEST_F(LogReading, DetectsTextLogsByTheirFirstLine) {
  EXPECT_TRUE(
      read_log(directory_.write("a.txt", std::string(kHeader) + R"({"t": 0, "ranges": [1, 1, 1]})"))
          .ok());
  EXPECT_TRUE(
      read_log(directory_.write("b.txt", "FLASER 3 1 2 3 0 0 0 0 0 0 1.0 host 1.0\n")).ok());
}

}  // namespace
}  // namespace cornerfix::evaluation
