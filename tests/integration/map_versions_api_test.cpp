// The calls of http-api on former revisions of maps, against the real server.
#include <gmock/gmock.h>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using testing::Json;
using testing::Reply;

class MapVersionsApiTest : public ::testing::Test {
 protected:
  void SetUp() override {
    client_.put("/v1/maps/office", {{"lidar", testing::lidar_json()}});
    const auto drive = testing::mapping_drive();
    client_.post("/v1/maps/office/scans", testing::map_batch(drive, 0, drive.size()));
    mapped_ = client_.get("/v1/maps/office").json();
  }
  Json change() {
    return client_.put("/v1/maps/office", {{"parameters", {{"grid", {{"resolution_m", 0.1}}}}}})
        .json();
  }
  Json revisions() { return client_.get("/v1/maps/office/revisions").json()["revisions"]; }
  Reply roll_back(const Json& body) { return client_.post("/v1/maps/office/rollback", body); }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  testing::HttpClient client_{server_.port()};
  Json mapped_;
};

TEST_F(MapVersionsApiTest, ListsTheNewestFirst) {
  const Json changed = change();
  const Json list = revisions();
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0]["revision"], changed["revision"]);
  EXPECT_EQ(list[0]["digest"], changed["digest"]);
  EXPECT_EQ(list[0]["current"], true);
  EXPECT_EQ(list[0]["origin"], "settings");
  EXPECT_EQ(list[1]["revision"], mapped_["revision"]);
  EXPECT_EQ(list[1]["digest"], mapped_["digest"]);
  EXPECT_EQ(list[1]["features"], mapped_["features"]);
  EXPECT_EQ(list[1]["origin"], "scans");
  EXPECT_EQ(list[1]["current"], false);
  EXPECT_GT(list[1]["archive_bytes"], 0);
}

TEST_F(MapVersionsApiTest, GivesTheArchiveOfAKeptRevision) {
  const Json changed = change();
  const auto archive = [&](const std::string& revision) {
    return client_.get("/v1/maps/office/archive?revision=" + revision);
  };
  const Reply former = archive(mapped_["revision"].dump());
  ASSERT_EQ(former.status, 200) << former.body;
  EXPECT_EQ(client_.send("POST", "/v1/maps/former/archive", former.body, "application/vnd.sqlite3")
                .json()["digest"],
            mapped_["digest"]);
  EXPECT_EQ(archive(changed["revision"].dump()).body, client_.get("/v1/maps/office/archive").body);
  EXPECT_EQ(archive("99").status, 404);
  EXPECT_EQ(archive("x").status, 422);
}

TEST_F(MapVersionsApiTest, RollsBackToANewRevision) {
  const Json changed = change();
  const Reply reply = roll_back({{"revision", mapped_["revision"]}});
  EXPECT_EQ(reply.status, 200) << reply.body;
  EXPECT_EQ(reply.json()["revision"], changed["revision"].get<int>() + 1);
  EXPECT_EQ(reply.json()["digest"], mapped_["digest"]);
  EXPECT_EQ(reply.json()["features"], mapped_["features"]);
  EXPECT_EQ(client_.get("/v1/maps/office").json()["parameters"], mapped_["parameters"]);
  EXPECT_EQ(revisions()[0]["origin"], "roll_back");
}

TEST_F(MapVersionsApiTest, RefusesWhatIsNoKeptRevision) {
  change();
  const Reply unknown = roll_back({{"revision", 99}});
  EXPECT_EQ(unknown.status, 404);
  EXPECT_THAT(unknown.json()["detail"], HasSubstr("it has 3, 2"));
  EXPECT_EQ(roll_back({{"revision", 2}, {"force", true}}).status, 422);
  EXPECT_EQ(roll_back(Json::object()).status, 422);
  EXPECT_EQ(roll_back({{"revision", "2"}}).status, 422);
  EXPECT_EQ(client_.get("/v1/maps/lab/revisions").status, 404);
  EXPECT_EQ(client_.post("/v1/maps/lab/rollback", {{"revision", 1}}).status, 404);
}

TEST_F(MapVersionsApiTest, NamesTheVersionThatASessionUses) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  const std::string path = "/v1/sessions/" + id;
  EXPECT_TRUE(client_.get(path).json()["map_version"].is_null());
  const auto drive = testing::robot_drive();
  Json answer;
  for (std::uint64_t sequence = 0; answer["status"] != "localized" && sequence < 12; ++sequence)
    answer = client_.post(path + "/scans", testing::session_batch(drive, sequence)).json();
  ASSERT_EQ(answer["status"], "localized") << answer.dump(1);
  Json used = {{"map", "office"},
               {"revision", mapped_["revision"]},
               {"digest", mapped_["digest"]},
               {"current", true}};
  EXPECT_EQ(client_.get(path).json()["map_version"], used);
  EXPECT_EQ(client_.get("/v1/sessions").json()["sessions"][0]["map_version"], used);
  change();
  used["current"] = false;
  EXPECT_EQ(client_.get(path).json()["map_version"], used);
}

}  // namespace
}  // namespace cornerfix
