#include "cli/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "server/map_library.hpp"
#include "server/settings.hpp"
#include "server/store_access.hpp"
#include "support/fake_server.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Outcome {
  int exit_code = 0;
  std::string out;
  std::string err;
};

Outcome run(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "cornerfix");
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.exit_code = run_command_line(static_cast<int>(arguments.size()), arguments.data());
  outcome.out = ::testing::internal::GetCapturedStdout();
  outcome.err = ::testing::internal::GetCapturedStderr();
  return outcome;
}

constexpr const char* kHeader =
    R"({"name": "walk", "beams": 2, "angle_min": 0, "angle_increment": 1, )"
    R"("range_min": 0.1, "range_max": 9})"
    "\n";

/// Scans a metre apart; the poses of key scans only where they are marked.
std::string walk(int scans, bool with_key_scans = false) {
  std::string text = kHeader;
  for (int i = 0; i < scans; ++i) {
    const std::string number = std::to_string(i);
    text += R"({"t": )" + number + R"(, "ranges": [1, null], "odom": [)" + number +
            R"(, 0, 0], "pose": [)" + number + ", 0, 0]" +
            (with_key_scans && i % 3 == 0 ? R"(, "kf": 1)" : "") + "}\n";
  }
  return text;
}

class CommandLine : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
};

TEST_F(CommandLine, EndsWrongUseWithTwo) {
  const std::string log = directory_.write("a.jsonl", walk(3)).string();
  const std::string map = directory_.write("map.yaml", "").string();
  const std::vector<std::vector<const char*>> wrong = {
      {},
      {"dance"},
      {"map"},
      {"map", "build"},
      {"map", "build", "a"},
      {"map", "build", "a", "/no/such/log.jsonl"},
      {"map", "build", "a", log.c_str(), "--split", "2"},
      {"map", "build", "a", log.c_str(), "--stride", "0"},
      {"map", "build", "a", log.c_str(), "--db", "a.db", "--server", "http://127.0.0.1:1"},
      {"map", "build", "a", log.c_str(), "--db", "a.db", "--print-curl"},
      {"map", "show"},
      {"replay"},
      {"replay", log.c_str(), "--batch", "101"},
      {"replay", log.c_str(), "--from", "soon"},
      {"replay", log.c_str(), "--quickly"},
      {"simulate", map.c_str()},
      {"simulate", map.c_str(), "out.jsonl", "--beams", "1"},
      {"simulate", map.c_str(), "out.jsonl", "--fov", "400"},
      {"simulate", "/no/such/map.yaml", "out.jsonl"},
  };
  for (const auto& arguments : wrong) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << ::testing::PrintToString(arguments);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err, "");
  }
}

TEST_F(CommandLine, EndsHelpWithZero) {
  for (const std::vector<const char*>& arguments : std::vector<std::vector<const char*>>{
           {"--help"}, {"map", "--help"}, {"map", "build", "--help"}, {"replay", "--help"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_THAT(outcome.out, HasSubstr("Usage:"));
  }
}

TEST_F(CommandLine, TellsItsVersion) {
  const Outcome outcome = run({"--version"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, "cornerfix " CORNERFIX_VERSION "\n");
}

TEST_F(CommandLine, EndsWithOneWhatItCouldNotDo) {
  const std::string map = directory_.write("map.yaml", "resolution: 1").string();
  const Outcome outcome = run({"simulate", map.c_str(), "out.jsonl"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("image: missing"));
}

TEST_F(CommandLine, ListsMapsOverAllPages) {
  testing::FakeServer server([](const testing::FakeRequest& request) {
    if (request.path == "/v1/maps") {
      return testing::FakeAnswer{200, R"({"maps": [{"name": "attic", "revision": 3, "keyframes": 10,
          "features": 20, "bounds": {"min_x": -1, "min_y": 0, "max_x": 4, "max_y": 2.5},
          "updated": "2024-01-02T03:04:05Z"}], "next_page_token": "attic"})"};
    }
    EXPECT_EQ(request.path, "/v1/maps?page_token=attic");
    return testing::FakeAnswer{200, R"({"maps": [{"name": "cellar", "revision": 1, "bounds": null}],
        "next_page_token": null})"};
  });
  const Outcome outcome = run({"map", "list", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out,
            "NAME    REVISION  KEY FRAMES  FEATURES  SIZE         UPDATED\n"
            "attic   3         10          20        5.0 x 2.5 m  2024-01-02T03:04:05Z\n"
            "cellar  1         -           -         -            -\n");
}

TEST_F(CommandLine, WaitsForAReportAndSavesItsPicture) {
  int asked = 0;
  testing::FakeServer server([&asked](const testing::FakeRequest& request) {
    if (request.path == "/v1/maps/attic/report.svg") return testing::FakeAnswer{200, "<svg/>"};
    EXPECT_EQ(request.path, "/v1/maps/attic/report?wait=2");
    if (++asked < 3) return testing::FakeAnswer{202, R"({"state": "computing", "progress": 0.5})"};
    return testing::FakeAnswer{200, R"({"state": "done", "summary": "All well but one place.",
        "free_area_m2": 80, "features_per_100_m2": 12.5, "advice": ["Start elsewhere."],
        "areas": [{"x": 4, "y": 1.25, "radius_m": 2, "way_m": 9.5, "found": 0.75,
                   "looks_like": {"x": 30, "y": 1}, "better_start": null}]})"};
  });
  const std::string picture = (directory_.path() / "attic.svg").string();
  const Outcome outcome = run(
      {"map", "report", "attic", "--picture", picture.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "All well but one place.\n"
            "80 m2 free, 12.5 features in 100 m2\n\n"
            "HARD AREA  RADIUS  WAY    FOUND  LOOKS LIKE  BETTER START\n"
            "4.0, 1.2   2.0 m   9.5 m  75 %   30.0, 1.0   -\n"
            "- Start elsewhere.\n");
  std::ifstream file(picture);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "<svg/>");
}

TEST_F(CommandLine, SaysWhatTheServerSaysOfAnUnknownMap) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{404, R"({"title": "Not found", "detail": "there is no map attic"})"};
  });
  const Outcome outcome = run({"map", "delete", "attic", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "cornerfix: DELETE /v1/maps/attic: 404 there is no map attic\n");
}

/// A server without a map "attic" that answers all other requests with `answer`.
testing::FakeAnswer without_attic(const testing::FakeRequest& request, const std::string& answer) {
  if (request.method == "GET" && request.path == "/v1/maps/attic") return {404, "{}"};
  return {200, answer};
}

TEST_F(CommandLine, BuildsAMapInBatchesOfFifty) {
  const std::string log = directory_.write("walk.jsonl", walk(130)).string();
  testing::FakeServer server([](const testing::FakeRequest& request) {
    return without_attic(request, R"({"accepted": 40, "duplicates": 10, "keyframes": 7,
        "features": 5, "revision": 9})");
  });
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "attic: 130 scans (30 there already), 7 key frames, 5 features, revision 9\n");
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 5U);
  EXPECT_EQ(requests[1].method + " " + requests[1].path, "PUT /v1/maps/attic");
  const auto described = nlohmann::json::parse(requests[1].body);
  EXPECT_EQ(described["description"], "from walk.jsonl");
  EXPECT_EQ(described["lidar"]["beams"], 2);
  EXPECT_EQ(requests[2].method + " " + requests[2].path, "POST /v1/maps/attic/scans");
  const auto last = nlohmann::json::parse(requests[4].body);
  EXPECT_EQ(last["scans"].size(), 30U);
  EXPECT_EQ(last["lidar"]["beams"], 2);
  EXPECT_EQ(last["scans"][29], nlohmann::json::parse(R"({"stamp": 129.0, "ranges": [1.0, null],
      "pose": {"x": 129.0, "y": 0.0, "yaw": 0.0}})"));
}

TEST_F(CommandLine, LeavesWhatAMapSaysOfItselfWhenALaterDriveIsBuiltIntoIt) {
  const std::string log = directory_.write("walk.jsonl", walk(3)).string();
  testing::FakeServer server([](const testing::FakeRequest& request) {
    if (request.method == "GET")
      return testing::FakeAnswer{200, R"({"description": "top floor", "lidar": {"beams": 181}})"};
    return testing::FakeAnswer{200, R"({"accepted": 2, "duplicates": 1})"};
  });
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("1 of its scans have stamps that the map holds already"));
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 2U);
  EXPECT_EQ(requests[1].method + " " + requests[1].path, "POST /v1/maps/attic/scans");
}

TEST_F(CommandLine, LeavesAFloorMapThatTakesNoDrive) {
  const std::string log = directory_.write("walk.jsonl", walk(3)).string();
  testing::FakeServer server([](const testing::FakeRequest& request) {
    if (request.method == "GET")
      return testing::FakeAnswer{200, R"({"description": "", "lidar": null, "floor_map": true})"};
    return testing::FakeAnswer{
        409, R"({"title": "Conflict", "detail": "attic is made from a floor map"})"};
  });
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 2U);
  EXPECT_EQ(requests[1].method, "POST");
}

TEST_F(CommandLine, TellsAMapOnlyWhatItDoesNotSayOfItself) {
  const std::string log = directory_.write("walk.jsonl", walk(3)).string();
  testing::FakeServer server([](const testing::FakeRequest& request) {
    if (request.method == "GET")
      return testing::FakeAnswer{200, R"({"description": "top floor", "lidar": null})"};
    return testing::FakeAnswer{200, "{}"};
  });
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 3U);
  EXPECT_EQ(requests[1].method, "PUT");
  const auto told = nlohmann::json::parse(requests[1].body);
  EXPECT_FALSE(told.contains("description"));
  EXPECT_EQ(told["lidar"]["beams"], 2);
}

TEST_F(CommandLine, BuildsFromTheFirstShareAndFromKeyScansOnly) {
  const std::string log = directory_.write("walk.jsonl", walk(12, true)).string();
  testing::FakeServer server(
      [](const testing::FakeRequest& request) { return without_attic(request, "{}"); });
  const Outcome outcome = run(
      {"map", "build", "attic", log.c_str(), "--split", "0.5", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 3U);
  const auto scans = nlohmann::json::parse(requests[2].body)["scans"];
  ASSERT_EQ(scans.size(), 2U);  // 0 and 3 of the first six.
  EXPECT_EQ(scans[1]["stamp"], 3.0);
}

TEST_F(CommandLine, BuildsFromAllScansOfTheFirstShareWithoutTheirPoses) {
  const std::string log = directory_.write("walk.jsonl", walk(12, true)).string();
  testing::FakeServer server([](const testing::FakeRequest& request) {
    return without_attic(request, request.method == "GET" ? R"({"features": [{}, {}]})" : "{}");
  });
  const Outcome outcome = run({"map", "build", "attic", log.c_str(), "--slam", "--split", "0.5",
                               "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("attic: 6 scans (0 there already), 0 key frames, 2 features"));
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 4U);
  const auto scans = nlohmann::json::parse(requests[2].body)["scans"];
  ASSERT_EQ(scans.size(), 6U);
  EXPECT_EQ(scans[5], nlohmann::json::parse(R"({"stamp": 5.0, "ranges": [1.0, null],
      "odom": {"x": 5.0, "y": 0.0, "yaw": 0.0}})"));
  EXPECT_EQ(requests[3].method + " " + requests[3].path, "GET /v1/maps/attic/features");
}

TEST_F(CommandLine, BuildsIntoADatabaseFromALogWithoutPoses) {
  std::string text = kHeader;
  for (const char* stamp : {"0", "1", "2"})
    text += R"({"t": )" + std::string(stamp) + R"(, "ranges": [1, 2]})" + "\n";
  const std::string log = directory_.write("walk.jsonl", text).string();
  const std::string database = (directory_.path() / "maps.db").string();
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--slam", "--db", database.c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("attic: 3 scans (0 there already), 1 key frames"));
}

TEST_F(CommandLine, BuildsFromALogThatIsBrokenInPlacesAndTellsHowManyThereAre) {
  const std::string text = walk(6);
  const std::string log = directory_.write("walk.jsonl", text + "oops\n" + "{\n").string();
  const std::string database = (directory_.path() / "maps.db").string();
  const Outcome outcome = run({"map", "build", "attic", log.c_str(), "--db", database.c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("attic: 6 scans"));
  EXPECT_THAT(outcome.err, HasSubstr("2 broken records left out, the first at line 8, byte " +
                                     std::to_string(text.size())));
}

TEST_F(CommandLine, BeginsNoMapWithALogThatHoldsNoPose) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{200, "{}"};
  });
  const std::string log =
      directory_.write("walk.jsonl", std::string(kHeader) + R"({"t": 0, "ranges": [1, 2]})")
          .string();
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("holds no scan with a pose, in 1 scans"));
  EXPECT_TRUE(server.requests().empty());
}

TEST_F(CommandLine, BuildsIntoADatabaseAndSkipsWhatIsThere) {
  const std::string log = directory_.write("walk.jsonl", walk(60)).string();
  const std::string database = (directory_.path() / "maps.db").string();
  const std::vector<const char*> arguments = {"map",       "build", "attic",
                                              log.c_str(), "--db",  database.c_str()};
  const Outcome first = run(arguments);
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("attic: 60 scans (0 there already), 60 key frames"));
  const Outcome second = run(arguments);
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("attic: 60 scans (60 there already), 60 key frames"));
  EXPECT_THAT(second.err, HasSubstr("nothing was added"));
}

TEST_F(CommandLine, LeavesInADatabaseWhatAMapSaysOfItselfAndAFloorMapAltogether) {
  const std::string first = directory_.write("first.jsonl", walk(3)).string();
  const std::string later = directory_.write("later.jsonl", walk(6)).string();
  const std::string yaml = CORNERFIX_SOURCE_DIR "/tests/data/willow_full_0.05.yaml";
  const std::string database = (directory_.path() / "maps.db").string();
  const auto build = [&](const char* map, const std::string& log) {
    return run({"map", "build", map, log.c_str(), "--db", database.c_str()}).exit_code;
  };
  ASSERT_EQ(build("attic", first), 0);
  ASSERT_EQ(build("attic", later), 0);
  ASSERT_EQ(run({"map", "import", "plan", yaml.c_str(), "--db", database.c_str()}).exit_code, 0);
  EXPECT_EQ(build("plan", later), 1);

  const auto stores = server::StoreAccess::open(database);
  ASSERT_TRUE(stores);
  server::MapLibrary maps(*stores, {}, [] { return std::string(); });
  EXPECT_EQ(maps.find("attic")->description, "from first.jsonl");
  EXPECT_EQ(maps.find("attic")->key_frame_count, 6U);
  EXPECT_EQ(maps.find("plan")->description, "");
  EXPECT_EQ(maps.find("plan")->lidar_json, "");
  EXPECT_EQ(maps.find("plan")->revision, 1U);
}

TEST_F(CommandLine, ImportsALargePgmInASmallBody) {
  const std::string yaml =
      directory_.write("map.yaml", "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n")
          .string();
  directory_.write("map.pgm", "P5 4096 4096 255\n" + std::string(4096 * 4096, '\xfe'));
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{200, R"({"features": 5})"};
  });
  const Outcome outcome =
      run({"map", "import", "attic", yaml.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 1U);
  EXPECT_LT(requests[0].length, 1'000'000U);
  EXPECT_GT(requests[0].length, 100U);
}

TEST_F(CommandLine, NamesTheCommandThatThereIsNot) {
  EXPECT_THAT(run({"dance"}).err, HasSubstr("there is no command dance\n"));
  EXPECT_THAT(run({"map", "dance", "--quickly"}).err, HasSubstr("there is no command dance\n"));
  EXPECT_THAT(run({"map"}).err, HasSubstr("subcommand is required"));
  EXPECT_THAT(run({"map", "show"}).err, HasSubstr("NAME is required"));
}

TEST_F(CommandLine, TellsTheRangeOfANumberInAFewWords) {
  const std::string log = directory_.write("a.jsonl", walk(3)).string();
  for (const char* number : {"0", "-1", "inf", "many"}) {
    EXPECT_THAT(run({"evaluate", log.c_str(), "--starts", number}).err,
                HasSubstr("--starts: expected a number above 0, not " + std::string(number)));
  }
  EXPECT_THAT(run({"replay", log.c_str(), "--rate", "-1"}).err,
              HasSubstr("--rate: expected a number from 0 on, not -1"));
  EXPECT_THAT(run({"evaluate", "--help"}).out, Not(HasSubstr("0000000")));
}

TEST_F(CommandLine, RefusesANameThatNoMapCanHave) {
  const std::string log = directory_.write("walk.jsonl", walk(3)).string();
  const std::string database = (directory_.path() / "maps.db").string();
  for (const std::vector<const char*>& arguments : std::vector<std::vector<const char*>>{
           {"map", "build", "a/b", log.c_str(), "--db", database.c_str()},
           {"map", "restore", "a/b", log.c_str()},
           {"map", "show", "a/b"},
           {"replay", log.c_str(), "--map", "a/b"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("a/b is no name for a map"));
  }
  EXPECT_FALSE(std::filesystem::exists(database));
}

TEST_F(CommandLine, EndsWithTwoWhereAFileIsMissingOrADirectory) {
  const std::string directory = directory_.path().string();
  for (const auto& [file, says] :
       {std::pair("/no/such/file", "does not exist"), std::pair(directory.c_str(), "directory")}) {
    for (const std::vector<const char*>& arguments : std::vector<std::vector<const char*>>{
             {"map", "restore", "a", file}, {"serve", "--db", "a.db", "--config", file}}) {
      const Outcome outcome = run(arguments);
      EXPECT_EQ(outcome.exit_code, 2);
      EXPECT_THAT(outcome.err, HasSubstr(says));
    }
  }
}

TEST_F(CommandLine, ListsEverySettingInTheHelpOfServe) {
  const Outcome outcome = run({"serve", "--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  ASSERT_FALSE(server::settings().empty());
  for (const server::Setting& setting : server::settings()) {
    EXPECT_THAT(outcome.out, HasSubstr(setting.flag()));
    EXPECT_THAT(outcome.out, HasSubstr(setting.variable()));
    EXPECT_THAT(outcome.out, HasSubstr(setting.default_value));
  }
}

TEST_F(CommandLine, TakesEverySettingAsAFlag) {
  const std::string file = directory_.write("config.json", "{").string();
  for (const server::Setting& setting : server::settings()) {
    const std::string flag = setting.flag();
    if (flag.empty()) continue;
    std::vector<const char*> arguments = {"serve", "--config", file.c_str(), flag.c_str()};
    if (setting.kind != server::Setting::Kind::kSwitch) arguments.push_back("1");
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("the configuration is not a JSON object")) << flag;
  }
}

TEST_F(CommandLine, NamesTheFlagOfAWrongSetting) {
  const Outcome outcome = run({"serve", "--db", "a.db", "--max-scans", "many"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--max-scans: expected an integer from 1 to"));
}

TEST_F(CommandLine, SaysThatADatabaseIsADirectory) {
  const std::string directory = directory_.path().string();
  const Outcome outcome = run({"serve", "--db", directory.c_str(), "--port", "0"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("is a directory"));
}

TEST_F(CommandLine, SaysThatAFileToRestoreIsEmpty) {
  const std::string file = directory_.write("a.cornerfix", "").string();
  const Outcome outcome = run({"map", "restore", "a", file.c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("is empty"));
}

TEST_F(CommandLine, TakesHttpServersOnly) {
  const Outcome outcome = run({"map", "list", "--server", "ftp://x"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("not ftp://x"));
}

/// A server that finds the robot at the third batch.
testing::FakeAnswer find_at_third_batch(const testing::FakeRequest& request) {
  if (request.path == "/v1/sessions") return {201, R"({"id": "s-1", "robot": "replay"})"};
  if (request.method == "DELETE") return {204, ""};
  const auto sequence = nlohmann::json::parse(request.body)["sequence"].get<int>();
  if (sequence < 2) {
    return {200, R"({"status": "collecting", "reason": "few_features", "pose": null})"};
  }
  return {200, R"({"status": "localized", "confidence": 0.99, "reason": null,
      "pose": {"map": "attic", "x": 5.1, "y": 0.0, "yaw": 0.0}})"};
}

TEST_F(CommandLine, ReplaysUntilSomeWayAfterTheFix) {
  const std::string log = directory_.write("walk.jsonl", walk(40)).string();
  testing::FakeServer server(find_at_third_batch);
  const Outcome outcome = run({"replay", log.c_str(), "--map", "attic", "--batch", "2", "--track",
                               "3", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("collecting  few_features"));
  EXPECT_THAT(outcome.out, HasSubstr("attic: x 5.10 m, y 0.00 m, yaw 0.0 deg (confidence 0.990)"));
  EXPECT_THAT(outcome.out,
              HasSubstr("true: x 5.00 m, y 0.00 m, yaw 0.0 deg; error 0.10 m, 0.0 deg"));
  const auto requests = server.requests();
  // Started, three batches until localized at 5 m, two more to 9 m, ended.
  ASSERT_EQ(requests.size(), 7U);
  EXPECT_EQ(nlohmann::json::parse(requests[0].body)["map"], "attic");
  EXPECT_EQ(requests[5].path, "/v1/sessions/s-1/scans");
  const auto batch = nlohmann::json::parse(requests[5].body);
  EXPECT_EQ(batch["sequence"], 4);
  EXPECT_EQ(batch["scans"][1]["odom"]["x"], 9.0);
  EXPECT_EQ(requests[6].method + " " + requests[6].path, "DELETE /v1/sessions/s-1");
}

TEST_F(CommandLine, ReplayEndsWithOneWhenTheLogEndsFirst) {
  const std::string log = directory_.write("walk.jsonl", walk(4)).string();
  testing::FakeServer server(find_at_third_batch);
  const Outcome outcome =
      run({"replay", log.c_str(), "--batch", "2", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
}

TEST_F(CommandLine, ReplayStartsWhereItIsTold) {
  const std::string log = directory_.write("walk.jsonl", walk(20)).string();
  const std::vector<std::pair<std::vector<const char*>, double>> first_stamps = {
      {{}, 0.0},
      {{"--from", "7"}, 7.0},
      {{"--from", "2.5s"}, 3.0},
      {{"--split", "0.5"}, 10.0},
      {{"--split", "0.5", "--from", "4"}, 14.0}};
  for (const auto& [options, stamp] : first_stamps) {
    testing::FakeServer server(find_at_third_batch);
    const std::string url = server.url();
    std::vector<const char*> arguments = {"replay", log.c_str(), "--no-odom", "--server",
                                          url.c_str()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    run(arguments);
    const auto scans = nlohmann::json::parse(server.requests()[1].body)["scans"];
    EXPECT_EQ(scans[0]["stamp"], stamp);
    EXPECT_FALSE(scans[0].contains("odom"));
  }
}

TEST_F(CommandLine, PrintsCurlLinesInsteadOfSending) {
  const std::string log = directory_.write("walk.jsonl", walk(3)).string();
  for (const std::vector<const char*>& arguments :
       std::vector<std::vector<const char*>>{{"map", "list"},
                                             {"map", "show", "a"},
                                             {"map", "delete", "a"},
                                             {"map", "build", "a", log.c_str()},
                                             {"replay", log.c_str()}}) {
    testing::FakeServer server([](const testing::FakeRequest&) {
      return testing::FakeAnswer{200, "{}"};
    });
    const std::string url = server.url();
    std::vector<const char*> printing = arguments;
    printing.insert(printing.end(), {"--print-curl", "--server", url.c_str()});
    const Outcome outcome = run(printing);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(server.requests().empty());
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_THAT(line, HasSubstr("curl -sS --fail-with-body"));
      EXPECT_THAT(line, HasSubstr(url + "/v1/"));
    }
  }
}

}  // namespace
}  // namespace cornerfix::cli
