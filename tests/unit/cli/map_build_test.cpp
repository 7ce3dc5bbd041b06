#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "server/map_library.hpp"
#include "server/store_access.hpp"
#include "support/fake_server.hpp"
#include "unit/cli/command_run.hpp"

namespace cornerfix::cli {
namespace {

using ::testing::HasSubstr;

class MapBuild : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
};

/// A server without a map "attic" that answers all other requests with `answer`.
testing::FakeAnswer without_attic(const testing::FakeRequest& request, const std::string& answer) {
  if (request.method == "GET" && request.path == "/v1/maps/attic") return {404, "{}"};
  return {200, answer};
}

TEST_F(MapBuild, BuildsAMapInBatchesOfFifty) {
  const std::string log = directory_.write("walk.jsonl", walk(130)).string();
  testing::FakeServer server([](const testing::FakeRequest& request) {
    return without_attic(request, R"({"accepted": 40, "duplicates": 10, "keyframes": 7,
        "features": 5, "revision": 9})");
  });
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "attic: 130 scans (30 there already), 7 keyframes, 5 features, revision 9\n");
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

TEST_F(MapBuild, KeepsDescriptionAndLidarWhenALaterRunIsAdded) {
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

TEST_F(MapBuild, DescribesNoOccupancyMapThatRefusesARun) {
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

TEST_F(MapBuild, SendsOnlyTheDescriptionOrLidarThatAMapDoesNotHave) {
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
  const auto sent = nlohmann::json::parse(requests[1].body);
  EXPECT_FALSE(sent.contains("description"));
  EXPECT_EQ(sent["lidar"]["beams"], 2);
}

TEST_F(MapBuild, BuildsFromTheFirstShareAndFromKeyScansOnly) {
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

TEST_F(MapBuild, BuildsFromAllScansOfTheFirstShareWithoutTheirPoses) {
  const std::string log = directory_.write("walk.jsonl", walk(12, true)).string();
  testing::FakeServer server([](const testing::FakeRequest& request) {
    return without_attic(request, request.method == "GET" ? R"({"features": [{}, {}]})" : "{}");
  });
  const Outcome outcome = run({"map", "build", "attic", log.c_str(), "--slam", "--split", "0.5",
                               "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("attic: 6 scans (0 there already), 0 keyframes, 2 features"));
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 4U);
  const auto scans = nlohmann::json::parse(requests[2].body)["scans"];
  ASSERT_EQ(scans.size(), 6U);
  EXPECT_EQ(scans[5], nlohmann::json::parse(R"({"stamp": 5.0, "ranges": [1.0, null],
      "odom": {"x": 5.0, "y": 0.0, "yaw": 0.0}})"));
  EXPECT_EQ(requests[3].method + " " + requests[3].path, "GET /v1/maps/attic/features");
}

TEST_F(MapBuild, BuildsIntoADatabaseFromALogWithoutPoses) {
  std::string text = kLogHeader;
  for (const char* stamp : {"0", "1", "2"})
    text += R"({"t": )" + std::string(stamp) + R"(, "ranges": [1, 2]})" + "\n";
  const std::string log = directory_.write("walk.jsonl", text).string();
  const std::string database = (directory_.path() / "maps.db").string();
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--slam", "--db", database.c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("attic: 3 scans (0 there already), 1 keyframes"));
}

TEST_F(MapBuild, LeavesOutBrokenRecordsAndPrintsHowMany) {
  const std::string text = walk(6);
  const std::string log = directory_.write("walk.jsonl", text + "oops\n" + "{\n").string();
  const std::string database = (directory_.path() / "maps.db").string();
  const Outcome outcome = run({"map", "build", "attic", log.c_str(), "--db", database.c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("attic: 6 scans"));
  EXPECT_THAT(outcome.err, HasSubstr("2 broken records left out, the first at line 8, byte " +
                                     std::to_string(text.size())));
}

TEST_F(MapBuild, BeginsNoMapWithALogThatHoldsNoPose) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{200, "{}"};
  });
  const std::string log =
      directory_.write("walk.jsonl", std::string(kLogHeader) + R"({"t": 0, "ranges": [1, 2]})")
          .string();
  const Outcome outcome =
      run({"map", "build", "attic", log.c_str(), "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("holds no scan with a pose, in 1 scans"));
  EXPECT_TRUE(server.requests().empty());
}

TEST_F(MapBuild, BuildsIntoADatabaseAndSkipsWhatIsThere) {
  const std::string log = directory_.write("walk.jsonl", walk(60)).string();
  const std::string database = (directory_.path() / "maps.db").string();
  const std::vector<std::string> arguments = {"map",       "build", "attic",
                                              log.c_str(), "--db",  database.c_str()};
  const Outcome first = run(arguments);
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("attic: 60 scans (0 there already), 60 keyframes"));
  const Outcome second = run(arguments);
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("attic: 60 scans (60 there already), 60 keyframes"));
  EXPECT_THAT(second.err, HasSubstr("nothing was added"));
}

TEST_F(MapBuild, KeepsTheDescriptionOfAMapAndAllOfAnOccupancyMapInADatabase) {
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

}  // namespace
}  // namespace cornerfix::cli
