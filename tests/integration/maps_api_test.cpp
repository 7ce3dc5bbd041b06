// The calls of http-api on maps, against the real server.
#include <gmock/gmock.h>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Json;
using ::testing::Not;
using testing::Reply;
using ::testing::StartsWith;

class MapsApiTest : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  testing::HttpClient client_{server_.port()};
  std::vector<PosedScan> drive_ = testing::mapping_drive();

  Json entry(const std::string& name) { return client_.get("/v1/maps/" + name).json(); }

  /// Of the map "office", of what stands at `place`.
  std::size_t features_near(const Point2& place) {
    std::size_t near = 0;
    const Json answer = client_.get("/v1/maps/office/features").json();
    for (const Json& feature : answer["features"]) {
      near += (Point2(feature["x"], feature["y"]) - place).norm() < 1.2 ? 1U : 0U;
    }
    return near;
  }
};

TEST_F(MapsApiTest, CreatesAndDescribes) {
  const Reply created = client_.put("/v1/maps/office", {{"description", "ground floor"}});
  EXPECT_EQ(created.status, 201);
  EXPECT_EQ(created.header("location"), "/v1/maps/office");
  const Reply described = client_.put("/v1/maps/office", {{"description", "first floor"}});
  EXPECT_EQ(described.status, 200);
  EXPECT_EQ(entry("office")["description"], "first floor");
  EXPECT_EQ(entry("office")["revision"], created.json()["revision"]);
}

TEST_F(MapsApiTest, CreatesWithoutABody) {
  EXPECT_EQ(client_.send("PUT", "/v1/maps/office", "", "").status, 201);  // Content-Length: 0
  const std::string answer = testing::exchange_bytes(
      server_.port(),
      "PUT /v1/maps/other HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 201"));
}

TEST_F(MapsApiTest, RefusesAnInvalidName) {
  const std::string long_name(129, 'a');
  for (const std::string& name : {std::string("-a"), std::string("a%20b"), std::string(".a"),
                                  std::string("a%2Fb"), std::string("%C3%A4"), long_name}) {
    EXPECT_EQ(client_.put("/v1/maps/" + name, Json::object()).status, 422) << name;
  }
  EXPECT_THAT(client_.get("/v1/maps").json()["maps"], IsEmpty());
}

TEST_F(MapsApiTest, DecodesANameOnce) {
  EXPECT_EQ(client_.put("/v1/maps/%6Fffice", Json::object()).status, 201);
  EXPECT_EQ(client_.get("/v1/maps/office").status, 200);
}

TEST_F(MapsApiTest, NeverMakesAMapOnTheWay) {
  for (const Reply& reply :
       {client_.get("/v1/maps/office"), client_.remove("/v1/maps/office"),
        client_.post("/v1/maps/office/scans", testing::map_batch(drive_, 0, 2)),
        client_.put("/v1/maps/office/trajectory", {{"poses", Json::array()}}),
        client_.get("/v1/maps/office/features"), client_.get("/v1/maps/office/grid.png"),
        client_.get("/v1/maps/office/grid.yaml"),
        client_.get("/v1/maps/office/features/0/descriptor"),
        client_.post("/v1/maps/office/localize", {{"scans", Json::array()}})}) {
    EXPECT_EQ(reply.status, 404);
    EXPECT_EQ(reply.header("content-type"), "application/problem+json");
  }
  EXPECT_THAT(client_.get("/v1/maps").json()["maps"], IsEmpty());
}

TEST_F(MapsApiTest, GrowsByBatchesAndCountsDuplicates) {
  client_.put("/v1/maps/office", {{"lidar", testing::lidar_json()}});
  const Json first =
      client_.post("/v1/maps/office/scans", testing::map_batch(drive_, 0, 24)).json();
  EXPECT_EQ(first["accepted"], 24);
  const Json second =
      client_.post("/v1/maps/office/scans", testing::map_batch(drive_, 12, 24)).json();
  EXPECT_EQ(second["accepted"], 12);
  EXPECT_EQ(second["duplicates"], 12);
  EXPECT_GT(second["keyframes"], first["keyframes"]);
  EXPECT_EQ(second["revision"], first["revision"].get<int>() + 1);
  const Json again =
      client_.post("/v1/maps/office/scans", testing::map_batch(drive_, 12, 24)).json();
  EXPECT_EQ(again["accepted"], 0);
  EXPECT_EQ(again["revision"], second["revision"]);
  EXPECT_EQ(entry("office")["keyframes"], second["keyframes"]);
  EXPECT_EQ(entry("office")["features"], second["features"]);
  EXPECT_FALSE(entry("office")["bounds"].is_null());
}

TEST_F(MapsApiTest, UpdatesAMapOfARoomThatIsMappedAgain) {
  testing::make_room_map(client_, "office");
  const Json before = entry("office");
  EXPECT_GT(features_near(testing::kOldObstacle), 0U);
  EXPECT_EQ(features_near(testing::kNewObstacle), 0U);
  const auto later = testing::mapping_drive(1e6, testing::refurnished_room());
  const Reply updated = client_.post("/v1/maps/office/scans", testing::map_batch(later, 0, 48));
  ASSERT_EQ(updated.status, 200) << updated.body;
  EXPECT_EQ(updated.json()["accepted"], 48);
  EXPECT_EQ(updated.json()["revision"], before["revision"].get<int>() + 1);
  EXPECT_EQ(features_near(testing::kOldObstacle), 0U);
  EXPECT_GT(features_near(testing::kNewObstacle), 0U);
  EXPECT_NE(entry("office")["digest"], before["digest"]);
  EXPECT_EQ(entry("office")["features"], updated.json()["features"]);

  const Json after = entry("office");
  const Reply again = client_.post("/v1/maps/office/scans", testing::map_batch(later, 0, 48));
  EXPECT_EQ(again.json()["duplicates"], 48);
  EXPECT_EQ(entry("office"), after);
}

TEST_F(MapsApiTest, ChecksTheNumberOfRangesAgainstTheLidarsBeamsOnly) {
  Json lidar = testing::lidar_json();
  lidar["beams"] = 360;
  client_.put("/v1/maps/office", {{"lidar", lidar}});
  Json batch = testing::map_batch(drive_, 0, 1);
  batch.erase("lidar");
  EXPECT_EQ(client_.post("/v1/maps/office/scans", batch).status, 200);
  batch["scans"][0]["stamp"] = 1e6;
  batch["scans"][0]["ranges"].push_back(1.0);
  EXPECT_EQ(client_.post("/v1/maps/office/scans", batch).status, 422);
  batch["scans"][0].update({{"angle_min", 0}, {"angle_increment", 0.01}});
  EXPECT_EQ(client_.post("/v1/maps/office/scans", batch).status, 200);
  batch["scans"][0]["stamp"] = 2e6;
  batch["lidar"] = {
      {"angle_min", 0}, {"angle_increment", 0.01}, {"range_min", 0}, {"range_max", 9}};
  EXPECT_EQ(client_.post("/v1/maps/office/scans", batch).status, 200);
}

TEST_F(MapsApiTest, ListsByPages) {
  for (const char* name : {"c", "a", "b"}) {
    client_.put(std::string("/v1/maps/") + name, Json::object());
  }
  const Json first = client_.get("/v1/maps?limit=2").json();
  ASSERT_EQ(first["maps"].size(), 2U);
  EXPECT_EQ(first["maps"][0]["name"], "a");
  const std::string token = first["next_page_token"];
  const Json second = client_.get("/v1/maps?limit=2&page_token=" + token).json();
  ASSERT_EQ(second["maps"].size(), 1U);
  EXPECT_EQ(second["maps"][0]["name"], "c");
  EXPECT_TRUE(second["next_page_token"].is_null());
  EXPECT_EQ(client_.get("/v1/maps?limit=0").status, 422);
  EXPECT_EQ(client_.get("/v1/maps?limit=x").status, 422);
}

TEST_F(MapsApiTest, ShowsFeaturesAndTheirDescriptors) {
  testing::make_room_map(client_, "office");
  const Json all = client_.get("/v1/maps/office/features").json();
  ASSERT_GT(all["features"].size(), 5U);
  EXPECT_EQ(all["revision"], entry("office")["revision"]);
  const Json some = client_.get("/v1/maps/office/features?bbox=0,0,5,5").json();
  EXPECT_LT(some["features"].size(), all["features"].size());
  for (const Json& feature : some["features"]) EXPECT_LE(feature["x"], 5.0);
  const std::string id = all["features"][1]["id"].dump();
  const Reply descriptor = client_.get("/v1/maps/office/features/" + id + "/descriptor");
  EXPECT_EQ(descriptor.status, 200) << descriptor.body;
  EXPECT_EQ(client_.get("/v1/maps/office/features/9999/descriptor").status, 404);
  EXPECT_EQ(client_.get("/v1/maps/office/features/-1/descriptor").status, 404);
  EXPECT_EQ(client_.get("/v1/maps/office/features?bbox=0,0,5").status, 422);
}

TEST_F(MapsApiTest, ServesTheGridAsMapServerFiles) {
  testing::make_room_map(client_, "office");
  const Reply png = client_.get("/v1/maps/office/grid.png");
  EXPECT_EQ(png.status, 200);
  EXPECT_EQ(png.header("content-type"), "image/png");
  EXPECT_THAT(png.body, StartsWith("\x89PNG"));
  EXPECT_EQ(client_.get("/v1/maps/office/grid.png", {{"If-None-Match", png.header("etag")}}).status,
            304);
  const Reply yaml = client_.get("/v1/maps/office/grid.yaml");
  EXPECT_THAT(yaml.body, HasSubstr("image: grid.png"));
  EXPECT_THAT(yaml.body, HasSubstr("resolution: 0.05"));
}

TEST_F(MapsApiTest, HasNoGridBeforeTheFirstKeyFrame) {
  client_.put("/v1/maps/office", Json::object());
  EXPECT_EQ(client_.get("/v1/maps/office/grid.png").status, 404);
  EXPECT_EQ(client_.get("/v1/maps/office/grid.yaml").status, 404);
  EXPECT_THAT(client_.get("/v1/maps/office/features").json()["features"], IsEmpty());
}

TEST_F(MapsApiTest, MovesTheMapToATrajectory) {
  testing::make_room_map(client_, "office");
  const Json before = entry("office");
  Json poses = Json::array();
  for (const PosedScan& scan : drive_) {
    Json pose = testing::pose_json(Pose2{10.0, 0.0, 0.0} * scan.T_map_base_link);
    pose["stamp"] = scan.scan.stamp;
    poses.push_back(pose);
  }
  const Reply moved = client_.put("/v1/maps/office/trajectory", {{"poses", poses}});
  ASSERT_EQ(moved.status, 200) << moved.body;
  EXPECT_EQ(entry("office")["revision"], before["revision"].get<int>() + 1);
  EXPECT_NE(entry("office")["digest"], before["digest"]);
  const Json features = client_.get("/v1/maps/office/features").json()["features"];
  EXPECT_THAT(features, Not(IsEmpty()));
  for (const Json& feature : features) EXPECT_GT(feature["x"], 9.0);
}

TEST_F(MapsApiTest, RefusesATrajectoryThatLeavesKeyFramesOut) {
  testing::make_room_map(client_, "office");
  const Json before = entry("office");
  const Reply refused =
      client_.put("/v1/maps/office/trajectory",
                  {{"poses", {{{"stamp", drive_[0].scan.stamp}, {"x", 0}, {"y", 0}, {"yaw", 0}}}}});
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.json()["errors"][0]["pointer"], "/poses");
  EXPECT_EQ(entry("office"), before);
}

TEST_F(MapsApiTest, Deletes) {
  testing::make_room_map(client_, "office");
  const Reply deleted = client_.remove("/v1/maps/office");
  EXPECT_EQ(deleted.status, 204);
  EXPECT_THAT(deleted.body, IsEmpty());
  EXPECT_EQ(client_.get("/v1/maps/office").status, 404);
}

TEST_F(MapsApiTest, KeepsTheDigestOfTheSameContent) {
  testing::make_room_map(client_, "one");
  testing::make_room_map(client_, "two");
  EXPECT_EQ(entry("one")["digest"], entry("two")["digest"]);
  EXPECT_THAT(entry("one")["digest"].get<std::string>(), Not(IsEmpty()));
}

/// A batch of a run without poses.
Json unposed_batch(const testing::RobotDrive& drive, std::size_t begin, std::size_t count) {
  Json batch = testing::session_batch(drive, begin / count, count);
  batch.erase("sequence");
  batch["lidar"] = testing::lidar_json();
  return batch;
}

TEST_F(MapsApiTest, MakesAMapOfADriveWithoutPoses) {
  const testing::RobotDrive drive = testing::robot_drive(60);
  client_.put("/v1/maps/office", {{"lidar", testing::lidar_json()}});
  for (const std::size_t begin : {0, 30}) {
    const Reply taken = client_.post("/v1/maps/office/scans", unposed_batch(drive, begin, 30));
    ASSERT_EQ(taken.status, 200) << taken.body;
    EXPECT_EQ(taken.json()["accepted"], 30);
  }
  const Reply again = client_.post("/v1/maps/office/scans", unposed_batch(drive, 30, 30));
  EXPECT_EQ(again.json()["duplicates"], 30);
  EXPECT_THAT(client_.get("/v1/maps/office/features").json()["features"], Not(IsEmpty()));
  EXPECT_EQ(client_.get("/v1/maps/office/grid.png").status, 200);
}

TEST_F(MapsApiTest, RefusesToMixScansWithAndWithoutPoses) {
  testing::make_room_map(client_, "office");
  const Json before = entry("office");
  const Reply refused =
      client_.post("/v1/maps/office/scans", unposed_batch(testing::robot_drive(10), 0, 10));
  EXPECT_EQ(refused.status, 409) << refused.body;
  EXPECT_EQ(refused.json()["code"], "conflict");
  EXPECT_EQ(entry("office"), before);
}

}  // namespace
}  // namespace cornerfix
