// Changes of maps with If-Match, against the real server.
#include <gmock/gmock.h>

#include <functional>

#include <cornerfix/map_image.hpp>

#include "integration/test_server.hpp"
#include "support/drawn_grid.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using testing::Json;
using testing::Reply;

constexpr const char* kJson = "application/json";

/// A call that changes a map.
struct Change {
  const char* name;
  std::string method;
  std::string path;  ///< Below the map's.
  std::string body;
  std::string content_type = kJson;
};

std::string form_of_a_room() {
  const OccupancyGrid grid = testing::drawn_grid(testing::figure7_room(), {5.0, 5.0},
                                                 {-1.0, -1.0, 0.0}, {12.0, 12.0}, 0.05);
  const auto png = encode_grid_png(grid);
  const auto part = [](const std::string& name, const std::string& content) {
    return "--xyz\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" + content +
           "\r\n";
  };
  return part("yaml", encode_grid_yaml(grid, "room.png")) +
         part("image", {reinterpret_cast<const char*>(png.data()), png.size()}) + "--xyz--\r\n";
}

class MapPreconditionsApiTest : public ::testing::Test {
 protected:
  void SetUp() override {
    client_.put("/v1/maps/office", {{"lidar", testing::lidar_json()}});
    client_.post("/v1/maps/office/scans", testing::map_batch(drive_, 0, drive_.size() - 5));
  }

  Reply send(const Change& change, const std::string& if_match) {
    return client_.send(change.method, "/v1/maps/office" + change.path, change.body,
                        change.content_type, {{"If-Match", if_match}});
  }
  std::string tag() { return client_.get("/v1/maps/office").header("etag"); }
  Json entry() { return client_.get("/v1/maps/office").json(); }

  Json poses() {
    Json poses = Json::array();
    for (const PosedScan& scan : drive_) {
      Json pose = testing::pose_json(scan.T_map_base_link);
      pose["stamp"] = scan.scan.stamp;
      pose["x"] = scan.T_map_base_link.x + 1.0;
      poses.push_back(pose);
    }
    return {{"poses", poses}};
  }
  std::vector<Change> changes() {
    const Json parameters = {{"parameters", {{"grid", {{"resolution_m", 0.1}}}}}};
    const Json revision = client_.get("/v1/maps/office").json()["revision"];
    return {{"parameters", "PUT", "", parameters.dump()},
            {"scans", "POST", "/scans", testing::map_batch(drive_, drive_.size() - 5, 5).dump()},
            {"description", "PUT", "", R"({"description": "ground floor"})"},
            {"trajectory", "PUT", "/trajectory", poses().dump()},
            {"roll-back", "POST", "/rollback", Json{{"revision", revision}}.dump()},
            {"deletion", "DELETE", "", "", ""}};
  }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  testing::HttpClient client_{server_.port()};
  std::vector<PosedScan> drive_ = testing::mapping_drive();
};

TEST_F(MapPreconditionsApiTest, RefusesEveryChangeOfAMapThatWasChangedInTheMeantime) {
  const std::string stale = tag();
  const std::string stale_digest = "\"" + entry()["digest"].get<std::string>() + "\"";
  const std::vector<Change> changes = this->changes();
  client_.put("/v1/maps/office", {{"parameters", {{"min_feature_count", 3}}}});
  const Json before = entry();
  for (const Change& change : changes) {
    for (const std::string& tags : {stale, stale_digest, std::string("W/") + tag()}) {
      const Reply refused = send(change, tags);
      EXPECT_EQ(refused.status, 412) << change.name << " " << refused.body;
      EXPECT_EQ(refused.json()["code"], "precondition_failed") << change.name;
      EXPECT_THAT(refused.json()["detail"].get<std::string>(), HasSubstr("If-Match"));
    }
  }
  EXPECT_EQ(entry(), before);
}

TEST_F(MapPreconditionsApiTest, TakesChangesOfTheMapAsItIs) {
  for (const Change& change : changes()) {
    const Reply taken = send(change, R"("other", )" + tag());
    EXPECT_EQ(taken.status / 100, 2) << change.name << " " << taken.body;
  }
  EXPECT_EQ(client_.get("/v1/maps/office").status, 404);
}

TEST_F(MapPreconditionsApiTest, KnowsAMapByItsDigest) {
  const std::string digest = "\"" + entry()["digest"].get<std::string>() + "\"";
  EXPECT_EQ(send(changes().front(), digest).status, 200);
}

TEST_F(MapPreconditionsApiTest, TakesAnyPresentMapWithAStarAndNoOther) {
  const Change described{"description", "PUT", "", R"({"description": "ground floor"})"};
  EXPECT_EQ(send(described, "*").status, 200);
  client_.remove("/v1/maps/office");
  EXPECT_EQ(send(described, "*").status, 412);
  EXPECT_EQ(client_.get("/v1/maps/office").status, 404);
}

TEST_F(MapPreconditionsApiTest, ChecksTheMapThatAnOccupancyMapReplaces) {
  const std::string form = "multipart/form-data; boundary=xyz";
  ASSERT_EQ(client_.send("PUT", "/v1/maps/plan/grid", form_of_a_room(), form).status, 201);
  for (const testing::HeaderMap& headers :
       {testing::HeaderMap{{"If-Match", tag()}},
        testing::HeaderMap{{"If-Match", tag()}, {"Prefer", "respond-async"}}}) {
    const Reply refused =
        client_.send("PUT", "/v1/maps/plan/grid", form_of_a_room(), form, headers);
    EXPECT_EQ(refused.status, 412) << refused.body;
  }
  const std::string own = client_.get("/v1/maps/plan").header("etag");
  EXPECT_EQ(
      client_.send("PUT", "/v1/maps/plan/grid", form_of_a_room(), form, {{"If-Match", own}}).status,
      200);
}

TEST_F(MapPreconditionsApiTest, GivesAnotherTagWithEveryChange) {
  const std::string before = tag();
  EXPECT_EQ(tag(), before);
  const Reply changed =
      client_.put("/v1/maps/office", {{"parameters", {{"min_feature_count", 3}}}});
  EXPECT_NE(changed.header("etag"), before);
  EXPECT_EQ(changed.header("etag"), tag());
}

}  // namespace
}  // namespace cornerfix
