// `cornerfix evaluate` as a user calls it, on short simulated runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/temporary_directory.hpp"
#include "unit/cli/command_run.hpp"

namespace cornerfix::cli {
namespace {

using ::testing::HasSubstr;

/// Two drives through the building in tests/data, made once.
class EvaluateCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    directory_ = new testing::TemporaryDirectory;
    simulate("map.jsonl", "1", "30");
    simulate("ask.jsonl", "2", "12");
  }
  static void TearDownTestSuite() {
    delete directory_;
    directory_ = nullptr;
  }

  static void simulate(const std::string& name, const std::string& seed,
                       const std::string& length) {
    const Outcome outcome =
        run({"simulate", CORNERFIX_SOURCE_DIR "/tests/data/willow_full_0.05.yaml", path(name),
             "--seed", seed, "--length", length, "--step", "0.3", "--beams", "270"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }

  static std::string path(const std::string& name) { return (directory_->path() / name).string(); }

  static testing::TemporaryDirectory* directory_;
};

testing::TemporaryDirectory* EvaluateCommand::directory_ = nullptr;

TEST_F(EvaluateCommand, PrintsAllFiguresOfTheReplayToolByTheirNames) {
  const Outcome outcome =
      run({"evaluate", path("map.jsonl"), "--starts", "3", "--way", "5", "--threads", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto figures = nlohmann::json::parse(outcome.out);
  for (const char* name : {"log",
                           "split",
                           "map_scans",
                           "map_seconds",
                           "features",
                           "starts",
                           "fixed",
                           "false",
                           "none",
                           "success",
                           "success_interval",
                           "success_5m",
                           "outside",
                           "outside_false",
                           "answers_judged",
                           "wrong_answers",
                           "starts_with_wrong_answer",
                           "wrong_interval",
                           "wrong_later",
                           "wrong_withdrawn",
                           "way_m",
                           "seconds",
                           "error_m",
                           "error_deg",
                           "tracked_right",
                           "server_ms_per_scan",
                           "rtt_ms_per_scan",
                           "scans",
                           "wall_s"}) {
    EXPECT_TRUE(figures.contains(name)) << name;
  }
  EXPECT_EQ(figures["log"], "map");
  EXPECT_EQ(figures["split"], "0.5");
  EXPECT_EQ(figures["starts"].get<int>() + figures["outside"].get<int>(), 3);
  EXPECT_TRUE(figures["server_ms_per_scan"].contains("max"));
  EXPECT_EQ(figures["false"].get<int>() + figures["outside_false"].get<int>(), 0);
  EXPECT_THAT(outcome.err, HasSubstr("starts: 100 %"));
}

TEST_F(EvaluateCommand, UpdatesTheMapByALaterLog) {
  const auto figures_with = [&](const std::vector<std::string>& arguments) {
    std::vector<std::string> all = {
        "evaluate", path("map.jsonl"), "--map-log", path("map.jsonl"), "--starts",
        "1",        "--way",           "1",         "--threads",       "1"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto alone = figures_with({});
  const auto updated = figures_with({"--update-log", path("map.jsonl")});
  EXPECT_EQ(updated["map_scans"].get<int>(), 2 * alone["map_scans"].get<int>());
  EXPECT_EQ(run({"evaluate", path("map.jsonl"), "--update-log", path("map.jsonl")}).exit_code, 2);
}

TEST_F(EvaluateCommand, WritesEveryStartsRecord) {
  const Outcome outcome =
      run({"evaluate", path("map.jsonl"), "--map-log", path("map.jsonl"), "--starts", "3", "--way",
           "4", "--track", "1", "--out", path("out.json"), "--threads", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::ifstream file(path("out.json"));
  const auto out = nlohmann::json::parse(file);
  EXPECT_EQ(out["summary"], nlohmann::json::parse(outcome.out));
  ASSERT_EQ(out["starts"].size(), 3U);
  std::size_t fixed = 0;
  for (const auto& start : out["starts"]) {
    EXPECT_EQ(start["near"], 0.0);
    EXPECT_EQ(start["ms"].size(), start["scans"].get<std::size_t>());
    EXPECT_EQ(start["rtt_ms"].size(), start["scans"].get<std::size_t>());
    if (start["result"] != "fixed") continue;
    ++fixed;
    EXPECT_LT(start["err"][0][0].get<double>(), 0.5);
    EXPECT_EQ(start["truth"].size(), 3U);
  }
  EXPECT_EQ(fixed, out["summary"]["fixed"].get<std::size_t>());
  EXPECT_GT(fixed, 0U);
}

TEST_F(EvaluateCommand, TakesEveryNthScan) {
  const auto scans = [&](const std::string& stride) {
    const Outcome outcome = run({"evaluate", path("map.jsonl"), "--stride", stride, "--starts", "1",
                                 "--way", "1", "--track", "0"});
    return nlohmann::json::parse(outcome.out)["map_scans"].get<double>();
  };
  EXPECT_NEAR(scans("1") / scans("3"), 3.0, 0.2);
}

TEST_F(EvaluateCommand, LetsBlocksOfWayTakeTurns) {
  const Outcome outcome = run({"evaluate", path("map.jsonl"), "--split", "blocks:5", "--starts",
                               "2", "--way", "2", "--track", "0"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["split"], "blocks:5");
}

TEST_F(EvaluateCommand, LooksInTheMapsOfFurtherLogsAsWell) {
  const Outcome outcome =
      run({"evaluate", path("ask.jsonl"), "--map-log", path("ask.jsonl"), "--any-map",
           path("map.jsonl"), "--starts", "2", "--way", "3", "--track", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["starts"], 2);
}

TEST_F(EvaluateCommand, MakesTheMapWithoutPoses) {
  const Outcome outcome = run({"evaluate", path("ask.jsonl"), "--map-log", path("ask.jsonl"),
                               "--slam", "--starts", "3", "--way", "8", "--track", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(summary["starts"], 3);
  EXPECT_EQ(summary["false"], 0) << outcome.out;
  EXPECT_GT(summary["fixed"], 0) << outcome.out;
}

TEST_F(EvaluateCommand, CountsStartsOutsideOfAnOccupancyMapApart) {
  const auto starts_in = [](const std::string& yaml) {
    const Outcome outcome = run({"evaluate", path("ask.jsonl"), "--map-grid", yaml, "--starts", "3",
                                 "--way", "1", "--track", "0"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto summary = nlohmann::json::parse(outcome.out);
    return std::pair(summary["starts"].get<int>(), summary["outside"].get<int>());
  };
  EXPECT_EQ(starts_in(CORNERFIX_SOURCE_DIR "/tests/data/willow_full_0.05.yaml"), std::pair(3, 0));

  std::string room = "P5 50 50 255\n";
  for (int row = 0; row < 50; ++row) {
    for (int column = 0; column < 50; ++column)
      room += row % 49 == 0 || column % 49 == 0 ? '\0' : '\xfe';
  }
  directory_->write("room.pgm", room);
  const auto far_away =
      directory_->write("room.yaml", "image: room.pgm\nresolution: 0.1\norigin: [900, 900, 0]\n");
  EXPECT_EQ(starts_in(far_away.string()), std::pair(0, 3));
}

TEST_F(EvaluateCommand, ScoresATrajectoryFoundWithoutPoses) {
  const Outcome outcome = run({"slam", path("ask.jsonl")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_GT(summary["keyframes"], 10);
  EXPECT_EQ(summary["relative_pose_error"][0]["way_m"], 2.0);
  EXPECT_LT(summary["relative_pose_error"][0]["error_m"]["p50"], 0.1);
  EXPECT_TRUE(summary.contains("revisits"));
}

TEST_F(EvaluateCommand, EndsArgumentsOutOfRangeWithTwo) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--split", "1.5"},
      {"--split", "blocks:0"},
      {"--split", "half"},
      {"--stride", "0"},
      {"--starts", "0"},
      {"--near", "-1"},
      {"--way", "0"},
      {"--time", "0"},
      {"--track", "-1"},
      {"--batch", "0"},
      {"--batch", "101"},
      {"--threads", "0"},
      {"--threads", "-1"},
      {"--method", "guess"},
      {"--odom-fault", "none"},
      {"--single-scan", "--report"},
      {"--any-map", "/no/such/log"},
      {"--slam", "--split", "blocks:5"},
      {"--slam", "--map-grid", CORNERFIX_SOURCE_DIR "/tests/data/willow_full_0.05.yaml"}};
  for (std::vector<std::string> arguments : wrong) {
    arguments.insert(arguments.begin(), {"evaluate", path("map.jsonl")});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << ::testing::PrintToString(arguments);
    EXPECT_EQ(outcome.out, "");
  }
}

TEST_F(EvaluateCommand, SaysWhatALogLacks) {
  const std::string header =
      R"({"name": "a", "beams": 2, "angle_min": 0, "angle_increment": 1, "range_max": 9})"
      "\n";
  const std::string no_poses =
      directory_->write("no_poses.jsonl", header + R"({"t": 0, "ranges": [1, 2]})" + "\n").string();
  Outcome outcome = run({"evaluate", no_poses});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("holds no scan with a pose in the part that maps"));
  outcome = run({"evaluate", path("map.jsonl"), "--split", "1"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("holds no scan with a pose in the part that asks"));
}

TEST_F(EvaluateCommand, CorruptsTheOdometryThatRobotsReport) {
  const auto figures_with = [&](const std::vector<std::string>& arguments) {
    std::vector<std::string> all = {
        "evaluate", path("ask.jsonl"), "--map-log", path("ask.jsonl"), "--starts", "2", "--way",
        "4",        "--track",         "3",         "--threads",       "1"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  for (const char* fault : {"zero", "hang", "two_publishers", "wrong_heading", "jump"}) {
    const auto figures = figures_with({"--odom-fault", fault});
    EXPECT_EQ(figures["starts"], 2) << fault;
  }
  // The same robots as with true odometry until something is reported wrongly: they differ.
  EXPECT_NE(figures_with({"--odom-fault", "zero"})["error_m"], figures_with({})["error_m"]);
  EXPECT_EQ(run({"evaluate", path("ask.jsonl"), "--odom-fault", "zero", "--no-odom"}).exit_code, 2);
}

TEST_F(EvaluateCommand, ForcesAnAnswerToASingleScan) {
  const Outcome outcome =
      run({"evaluate", path("ask.jsonl"), "--map-grid",
           CORNERFIX_SOURCE_DIR "/tests/data/willow_full_0.05.yaml", "--single-scan", "--starts",
           "5", "--threads", "1", "--out", path("single.json")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  const auto& mapped = summary["mapped"];
  EXPECT_EQ(mapped["scans"], 5);
  EXPECT_EQ(summary["outside"]["scans"], 0);
  EXPECT_EQ(mapped["top1_right"].get<int>() + mapped["top1_wrong"].get<int>() +
                mapped["top1_none"].get<int>(),
            5);
  EXPECT_LE(mapped["accepted_right"], mapped["top1_right"]);
  EXPECT_GT(mapped["top1_right"], 0);
  EXPECT_LE(mapped["top1_right_interval"][0], mapped["top1_right_interval"][1]);
  EXPECT_LT(summary["error_m"]["max"].get<double>(), 0.5);
  std::ifstream file(path("single.json"));
  EXPECT_EQ(nlohmann::json::parse(file)["starts"].size(), 5U);
}

TEST_F(EvaluateCommand, AcceptsNoSingleScanOfAnotherBuilding) {
  const Outcome outcome = run({"evaluate", path("ask.jsonl"), "--elsewhere", path("map.jsonl"),
                               "--single-scan", "--starts", "2", "--threads", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(summary["outside"]["scans"], 2);
  EXPECT_EQ(summary["outside"]["top1_right"], 0);
}

TEST_F(EvaluateCommand, ExplainsWhatTheDecisionSaw) {
  const std::vector<std::string> arguments = {
      "evaluate", path("ask.jsonl"), "--map-log", path("ask.jsonl"), "--way", "8", "--explain"};
  std::vector<std::string> first = arguments;
  first.insert(first.end(), {"0", "--out", path("explained")});
  const Outcome outcome = run(first);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto explanation = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(explanation["start"], 0);
  const auto& decision = explanation["decision"];
  ASSERT_TRUE(decision.is_object());
  EXPECT_EQ(decision["status"], "localized");
  ASSERT_FALSE(decision["poses"].empty());
  const auto& best = decision["poses"][0];
  EXPECT_TRUE(best["correct"]);
  int hits = 0;
  double llr = 0.0;
  for (const auto& hit_class : best["hits_by_class"]) hits += hit_class["count"].get<int>();
  for (const char* kind : {"hits_by_class", "misses_by_class"}) {
    for (const auto& one : best[kind]) llr += one["decision_llr"].get<double>();
  }
  EXPECT_EQ(hits, best["hits"]);
  EXPECT_NEAR(llr, best["decision_llr"].get<double>(), 0.05 * std::abs(llr));

  std::ifstream json(path("explained/start_0.json"));
  EXPECT_EQ(nlohmann::json::parse(json), explanation);
  std::ifstream png(path("explained/start_0.png"), std::ios::binary);
  std::string signature(4, '\0');
  png.read(signature.data(), 4);
  EXPECT_EQ(signature, "\x89PNG");

  std::vector<std::string> unknown = arguments;
  unknown.insert(unknown.end(), {"99999", "--out", path("explained")});
  EXPECT_EQ(run(unknown).exit_code, 1);
  std::vector<std::string> nowhere = arguments;
  nowhere.emplace_back("0");
  EXPECT_EQ(run(nowhere).exit_code, 2);
}

TEST_F(EvaluateCommand, LooksInFurtherOccupancyMapsAsWell) {
  const Outcome outcome =
      run({"evaluate", path("ask.jsonl"), "--map-log", path("ask.jsonl"), "--any-map",
           CORNERFIX_SOURCE_DIR "/tests/data/willow_full_0.05.yaml", "--starts", "1", "--way", "1",
           "--track", "0"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["starts"], 1);
}

TEST_F(EvaluateCommand, WarnsWhenNoStartHasEnoughLogAhead) {
  const Outcome outcome = run({"evaluate", path("ask.jsonl"), "--starts", "1", "--threads", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["starts"], 0);
  EXPECT_THAT(outcome.err, HasSubstr("no start counts"));
}

TEST_F(EvaluateCommand, PrintsHowManyBrokenRecordsItLeftOut) {
  std::ifstream log(path("ask.jsonl"));
  const std::string text((std::istreambuf_iterator<char>(log)), std::istreambuf_iterator<char>());
  const std::string broken = directory_->write("broken.jsonl", text + "oops\n").string();
  const Outcome outcome =
      run({"evaluate", broken, "--starts", "1", "--way", "1", "--track", "0", "--threads", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("1 broken record left out, the first at line "));
  EXPECT_THAT(outcome.err, HasSubstr("byte " + std::to_string(text.size())));
}

}  // namespace
}  // namespace cornerfix::cli
