// The calls of http-api on sessions, against the real server.
#include <gmock/gmock.h>

#include <set>
#include <string>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Json;
using testing::Reply;

class SessionsApiTest : public ::testing::Test {
 protected:
  SessionsApiTest() { testing::make_room_map(client_, "office"); }

  Reply post(const std::string& id, const Json& batch) {
    return client_.post("/v1/sessions/" + id + "/scans", batch);
  }
  Reply post(const std::string& id, std::uint64_t sequence) {
    return post(id, testing::session_batch(drive_, sequence));
  }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  testing::HttpClient client_{server_.port()};
  testing::RobotDrive drive_ = testing::robot_drive();
};

TEST_F(SessionsApiTest, OpensASession) {
  const Reply reply = client_.post("/v1/sessions", testing::session_request("cart-7", "office"));
  ASSERT_EQ(reply.status, 201) << reply.body;
  const std::string id = reply.json()["id"];
  EXPECT_EQ(reply.header("location"), "/v1/sessions/" + id);
  EXPECT_EQ(reply.json()["robot"], "cart-7");
  EXPECT_EQ(client_.get("/v1/sessions/" + id).json(), reply.json());
}

TEST_F(SessionsApiTest, OpensNoneOnAnUnknownMap) {
  EXPECT_EQ(client_.post("/v1/sessions", testing::session_request("cart-7", "nowhere")).status,
            404);
  Json request = testing::session_request("cart-7", nullptr);
  request["maps"] = {"office", "nowhere"};
  EXPECT_EQ(client_.post("/v1/sessions", request).status, 404);
  EXPECT_THAT(client_.get("/v1/sessions").json()["sessions"], IsEmpty());
}

TEST_F(SessionsApiTest, RefusesAnglesThatNoLidarHas) {
  for (const char* member : {"angle_min", "angle_increment"}) {
    Json request = testing::session_request("cart-7", "office");
    request["lidar"][member] = 1e308;
    const Reply reply = client_.post("/v1/sessions", request);
    EXPECT_EQ(reply.status, 422) << reply.body;
    EXPECT_EQ(reply.json()["errors"][0]["pointer"], std::string("/lidar/") + member);
  }
  const std::string id = testing::open_session(client_, "cart-7", "office");
  Json batch = testing::session_batch(drive_, 0);
  batch["scans"][0]["angle_increment"] = 1e308;
  const Reply reply = post(id, batch);
  EXPECT_EQ(reply.status, 422) << reply.body;
  EXPECT_EQ(reply.json()["errors"][0]["pointer"], "/scans/0/angle_increment");
  EXPECT_EQ(post(id, 0).status, 200);
}

TEST_F(SessionsApiTest, FindsTheRobot) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  Json answer;
  for (std::uint64_t i = 0; i < 10; ++i) {
    const Reply reply = post(id, i);
    ASSERT_EQ(reply.status, 200) << reply.body;
    answer = reply.json();
    EXPECT_EQ(answer["session"], id);
    EXPECT_EQ(answer["sequence"], i);
    EXPECT_EQ(answer["pose"].is_null(), answer["status"] != "localized");
  }
  ASSERT_EQ(answer["status"], "localized") << answer.dump(1);
  const Pose2& truth = drive_.T_map_base_link.back();
  const Json& pose = answer["pose"];
  EXPECT_EQ(pose["map"], "office");
  EXPECT_EQ(pose["revision"], client_.get("/v1/maps/office").json()["revision"]);
  EXPECT_EQ(pose["stamp"], drive_.scans.back().scan.stamp);
  EXPECT_NEAR(pose["x"], truth.x, 0.1);
  EXPECT_NEAR(pose["y"], truth.y, 0.1);
  EXPECT_NEAR(wrap_angle(pose["yaw"].get<double>() - truth.yaw), 0.0, 0.05);
  EXPECT_EQ(pose["covariance"].size(), 9U);
  EXPECT_GT(answer["timing_ms"]["total"], 0.0);
  EXPECT_EQ(client_.get("/v1/sessions/" + id).json()["status"], "localized");
}

TEST_F(SessionsApiTest, ATrackedRobotMovesToAnUpdatedMapWithoutAJump) {
  drive_ = testing::robot_drive(60, 2.0, testing::refurnished_room());
  const std::string id = testing::open_session(client_, "cart-7", "office");
  Json before;
  for (std::uint64_t i = 0; i < 10; ++i) before = post(id, i).json();
  ASSERT_EQ(before["status"], "localized") << before.dump(1);

  const auto later = testing::mapping_drive(1e6, testing::refurnished_room());
  for (const std::size_t begin : {0, 24}) {
    ASSERT_EQ(client_.post("/v1/maps/office/scans", testing::map_batch(later, begin, 24)).status,
              200);
    for (const std::uint64_t i : {10 + begin / 12, 11 + begin / 12}) {
      const Json after = post(id, i).json();
      ASSERT_EQ(after["status"], "localized") << after.dump(1);
      EXPECT_EQ(after["pose"]["revision"], client_.get("/v1/maps/office").json()["revision"]);
      const Pose2& truth = drive_.T_map_base_link.at(3 * i + 2);
      EXPECT_NEAR(after["pose"]["x"], truth.x, 0.05);
      EXPECT_NEAR(after["pose"]["y"], truth.y, 0.05);
      EXPECT_NEAR(wrap_angle(after["pose"]["yaw"].get<double>() - truth.yaw), 0.0, 0.02);
      for (const int diagonal : {0, 4, 8}) {
        EXPECT_LT(after["pose"]["covariance"][diagonal].get<double>(),
                  1.2 * before["pose"]["covariance"][diagonal].get<double>());
      }
      EXPECT_GE(after["local"]["scans"], before["local"]["scans"]);
      EXPECT_EQ(after["timing_ms"]["match"], 0.0);  // it does not look for its place again
    }
  }
}

TEST_F(SessionsApiTest, FindsTheRobotInAnyMap) {
  const std::string id = testing::open_session(client_, "cart-7", nullptr);
  for (std::uint64_t i = 0; i < 9; ++i) post(id, i);
  EXPECT_EQ(post(id, 9).json()["status"], "localized");
}

TEST_F(SessionsApiTest, TwinsAmongRankedMapsStayAmbiguousAndAreNamed) {
  const std::string archive = client_.get("/v1/maps/office/archive").body;
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    const Reply reply = client_.send("POST", std::string("/v1/maps/") + name + "/archive", archive,
                                     "application/vnd.sqlite3");
    ASSERT_EQ(reply.status, 201) << reply.body;
  }
  const std::string id = testing::open_session(client_, "cart-7", nullptr);
  Json answer;
  for (std::uint64_t i = 0; i < 9; ++i) answer = post(id, i).json();
  EXPECT_EQ(answer["status"], "ambiguous") << answer.dump(1);
  EXPECT_EQ(answer["searched_maps"], 6);
  std::set<std::string> named;
  for (const Json& hypothesis : answer["hypotheses"]) named.insert(hypothesis["map"]);
  EXPECT_GE(named.size(), 2U);
  for (const char* name : {"a", "b", "c", "d", "e"})
    ASSERT_EQ(client_.remove(std::string("/v1/maps/") + name).status, 204);
  EXPECT_EQ(post(id, 9).json()["searched_maps"], nullptr);
}

TEST_F(SessionsApiTest, AnswersTheSameSequenceWithTheSameBytes) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  post(id, 0);
  const Reply first = post(id, 1);
  const Json session = client_.get("/v1/sessions/" + id).json();
  const Reply again = post(id, 1);
  EXPECT_EQ(again.status, 200);
  EXPECT_EQ(again.body, first.body);
  EXPECT_EQ(client_.get("/v1/sessions/" + id).json(), session);
}

TEST_F(SessionsApiTest, SaysWhichSequenceItExpects) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  post(id, 0);
  post(id, 1);
  for (const std::uint64_t wrong : {0U, 3U}) {
    const Reply reply = post(id, wrong);
    EXPECT_EQ(reply.status, 409);
    EXPECT_EQ(reply.header("content-type"), "application/problem+json");
    EXPECT_EQ(reply.json()["expected"], 2);
  }
  EXPECT_EQ(post(id, 2).status, 200);
}

TEST_F(SessionsApiTest, AConflictHasTheStampOfTheLastScan) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  Reply conflict = post(id, 3);
  EXPECT_EQ(conflict.json()["expected"], 0);
  EXPECT_EQ(conflict.json()["last_stamp"], nullptr);
  post(id, 0);
  conflict = post(id, 3);
  EXPECT_EQ(conflict.status, 409);
  EXPECT_EQ(conflict.json()["expected"], 1);
  EXPECT_EQ(conflict.json()["last_stamp"], drive_.scans[2].scan.stamp);
}

TEST_F(SessionsApiTest, AnOlderSessionOfARobotIsSuperseded) {
  const std::string old = testing::open_session(client_, "cart-7", "office");
  const std::string id = testing::open_session(client_, "cart-7", "office");
  EXPECT_EQ(client_.get("/v1/sessions/" + old).json()["superseded_by"], id);
  EXPECT_EQ(client_.get("/v1/sessions/" + id).json()["superseded_by"], nullptr);
  EXPECT_EQ(client_.get("/v1/sessions/" + id).json()["stale"], false);
  const Json list = client_.get("/v1/sessions").json()["sessions"];
  EXPECT_EQ(list[0]["superseded_by"], id);
  EXPECT_EQ(post(old, 0).status, 200) << "it is answered as before";
}

TEST_F(SessionsApiTest, RefusesStampsThatDoNotIncrease) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  post(id, 0);
  Json batch = testing::session_batch(drive_, 1);
  batch["scans"][1]["stamp"] = batch["scans"][2]["stamp"];
  EXPECT_EQ(post(id, batch).status, 422);
  batch = testing::session_batch(drive_, 1);
  batch["scans"][0]["stamp"] = drive_.scans[2].scan.stamp;
  const Reply reply = post(id, batch);
  EXPECT_EQ(reply.status, 422);
  EXPECT_EQ(reply.json()["errors"][0]["pointer"], "/scans/0/stamp");
  EXPECT_EQ(post(id, 1).status, 200);
}

TEST_F(SessionsApiTest, RefusesAnotherNumberOfRangesThanTheLidarHasBeams) {
  Json lidar = testing::lidar_json();
  lidar["beams"] = 360;
  const Reply created =
      client_.post("/v1/sessions", {{"robot", "cart-7"}, {"map", "office"}, {"lidar", lidar}});
  const std::string id = created.json()["id"];
  Json batch = testing::session_batch(drive_, 0);
  batch["scans"][2]["ranges"].push_back(1.0);
  const Reply reply = post(id, batch);
  EXPECT_EQ(reply.status, 422);
  EXPECT_EQ(reply.json()["errors"][0]["pointer"], "/scans/2/ranges");
  EXPECT_EQ(post(id, 0).status, 200);
}

TEST_F(SessionsApiTest, TakesScansWhoseNumberOfBeamsVaries) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  post(id, 0);
  Json batch = testing::session_batch(drive_, 1);
  batch["scans"][1]["ranges"].erase(5);
  batch["scans"][2]["ranges"].push_back(1.0);
  batch["scans"][0].update({{"angle_min", -1.0}, {"angle_increment", 0.5}, {"ranges", {1, 2, 3}}});
  const Reply reply = post(id, batch);
  EXPECT_EQ(reply.status, 200) << reply.body;
}

TEST_F(SessionsApiTest, ForgetsOnReset) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  for (std::uint64_t i = 0; i < 9; ++i) post(id, i);
  const Reply reset = client_.send("POST", "/v1/sessions/" + id + "/reset", "", "");
  EXPECT_EQ(reset.status, 200);
  EXPECT_EQ(reset.json()["status"], "collecting");
  EXPECT_EQ(reset.json()["expected"], 9);
  EXPECT_EQ(reset.json()["last_answer"], nullptr);
  Json early = testing::session_batch(drive_, 0);
  early["sequence"] = 9;
  EXPECT_EQ(post(id, early).status, 200);
}

TEST_F(SessionsApiTest, ResetsWithoutContentLengthAtOnce) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  const std::string reply = testing::exchange_bytes(
      server_.port(), "POST /v1/sessions/" + id +
                          "/reset HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(reply, ::testing::StartsWith("HTTP/1.1 200"));
}

TEST_F(SessionsApiTest, FindsTheRobotNearAPlaceAndSaysSo) {
  Json request = testing::session_request("cart-7", "office");
  const Pose2& start = drive_.T_map_base_link.front();
  request["near"] = {{"x", start.x}, {"y", start.y}, {"radius_m", 1.0}, {"yaw", start.yaw}};
  const Reply opened = client_.post("/v1/sessions", request);
  ASSERT_EQ(opened.status, 201) << opened.body;
  EXPECT_EQ(opened.json()["near"]["yaw_tolerance_rad"], 0.8);
  const std::string id = opened.json()["id"];
  Json answer;
  for (std::uint64_t i = 0; i < 10; ++i) answer = post(id, i).json();
  EXPECT_EQ(answer["status"], "localized") << answer.dump(1);
  EXPECT_EQ(answer["given"], "near");
}

TEST_F(SessionsApiTest, ARobotThatIsNotNearThePlaceGetsNoPose) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  const Json near{{"x", 8.5}, {"y", 2.0}, {"radius_m", 0.8}};
  const Reply reset = client_.post("/v1/sessions/" + id + "/reset", {{"near", near}});
  ASSERT_EQ(reset.status, 200) << reset.body;
  EXPECT_EQ(reset.json()["near"], near);
  for (std::uint64_t i = 0; i < 10; ++i) {
    const Json answer = post(id, i).json();
    EXPECT_EQ(answer["status"], "collecting");
    EXPECT_EQ(answer["pose"], nullptr);
    if (i > 1) {
      EXPECT_EQ(answer["reason"], "prior_contradicted");
    }
  }
  EXPECT_EQ(client_.send("POST", "/v1/sessions/" + id + "/reset", "", "").json()["near"], nullptr);
}

TEST_F(SessionsApiTest, PointsToWhatIsWrongWithNear) {
  Json request = testing::session_request("cart-7", "office");
  request["near"] = {{"x", 1.0}, {"y", 2.0}, {"radius_m", -1.0}};
  Reply refused = client_.post("/v1/sessions", request);
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.json()["errors"][0]["pointer"], "/near/radius_m");
  request["near"] = {{"map", "hall"}, {"x", 1.0}, {"y", 2.0}, {"radius_m", 1.0}};
  refused = client_.post("/v1/sessions", request);
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.json()["errors"][0]["pointer"], "/near/map");
  for (const char* map : {"office", ""}) {  // The second is searched in every map.
    request["map"] = *map == '\0' ? Json(nullptr) : Json(map);
    request["near"] = {{"x", 1e4}, {"y", 2.0}, {"radius_m", 1.0}};
    refused = client_.post("/v1/sessions", request);
    EXPECT_EQ(refused.status, 422) << map;
    EXPECT_EQ(refused.json()["errors"][0]["pointer"], "/near") << map;
    EXPECT_THAT(refused.json()["detail"].get<std::string>(),
                HasSubstr("x 10000, y 2 with radius_m 1 lies outside the map office, expected x"))
        << map;
  }
  EXPECT_THAT(client_.get("/v1/sessions").json()["sessions"], IsEmpty());
}

/// A scan of a full turn as two lidars of half a turn would have taken it.
Json halves_of(const Json& scan) {
  const Json& ranges = scan["ranges"];
  const std::size_t beams = ranges.size();
  Json front = scan;
  Json rear = scan;
  front["lidar"] = "front";
  rear["lidar"] = "rear";
  front["ranges"] = rear["ranges"] = Json::array();
  for (std::size_t i = 0; i < beams / 2; ++i) {
    front["ranges"].push_back(ranges[beams / 4 + i]);
    rear["ranges"].push_back(ranges[(3 * beams / 4 + i) % beams]);
  }
  return Json::array({front, rear});
}

TEST_F(SessionsApiTest, RefusesAResetToAPlaceOutsideTheMap) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  const Json near{{"x", 1.0}, {"y", -1e4}, {"radius_m", 5.0}};
  const Reply refused = client_.post("/v1/sessions/" + id + "/reset", {{"near", near}});
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.json()["errors"][0]["pointer"], "/near");
}

TEST_F(SessionsApiTest, FindsARobotWithTwoLidars) {
  Json request = testing::session_request("cart-7", "office");
  Json half = request["lidar"];
  half["angle_min"] = half["angle_min"].get<double>() / 2.0;
  request.erase("lidar");
  request["lidars"] = {{"front", half}, {"rear", half}};
  request["lidars"]["rear"]["mount"] = testing::pose_json({0.0, 0.0, 3.14159265});
  const Reply opened = client_.post("/v1/sessions", request);
  ASSERT_EQ(opened.status, 201) << opened.body;
  EXPECT_EQ(opened.json()["lidar"], nullptr);
  EXPECT_EQ(opened.json()["lidars"].size(), 2U);
  Json answer;
  for (std::uint64_t i = 0; i < 10; ++i) {
    Json batch = testing::session_batch(drive_, i);
    Json scans = Json::array();
    for (const Json& scan : batch["scans"]) {
      for (const Json& one : halves_of(scan)) scans.push_back(one);
    }
    batch["scans"] = scans;
    const Reply reply = post(opened.json()["id"], batch);
    ASSERT_EQ(reply.status, 200) << reply.body;
    answer = reply.json();
  }
  ASSERT_EQ(answer["status"], "localized") << answer.dump(1);
  EXPECT_NEAR(answer["pose"]["x"], drive_.T_map_base_link.back().x, 0.1);
  EXPECT_NEAR(answer["pose"]["y"], drive_.T_map_base_link.back().y, 0.1);
}

TEST_F(SessionsApiTest, NeedsNoLidarWhenScansBringTheirGeometry) {
  Json request = testing::session_request("cart-7", "office");
  const Json lidar = request["lidar"];
  request.erase("lidar");
  const Reply opened = client_.post("/v1/sessions", request);
  ASSERT_EQ(opened.status, 201) << opened.body;
  EXPECT_EQ(opened.json()["lidar"], nullptr);
  Json batch = testing::session_batch(drive_, 0);
  const Reply refused = post(opened.json()["id"], batch);
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.json()["errors"][0]["pointer"], "/lidar");
  for (Json& scan : batch["scans"]) scan.update(lidar);
  EXPECT_EQ(post(opened.json()["id"], batch).status, 200);
}

TEST_F(SessionsApiTest, GivesAnswersInTheShapesOfRosAndVda5050) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  for (std::uint64_t i = 0; i < 10; ++i) post(id, i);
  const auto get_as = [&](const std::string& profile) {
    return client_.get("/v1/sessions/" + id, {{"Accept", "application/json; profile=" + profile}});
  };
  const Json pose = client_.get("/v1/sessions/" + id).json()["last_answer"]["pose"];
  ASSERT_FALSE(pose.is_null());
  const Reply ros = get_as("ros");
  EXPECT_EQ(ros.header("content-type"), "application/json; profile=ros");
  EXPECT_EQ(ros.json()["last_answer"]["pose"]["pose"]["pose"]["position"]["x"], pose["x"]);
  const Reply vda = get_as("vda5050");
  EXPECT_EQ(vda.header("content-type"), "application/json; profile=vda5050");
  EXPECT_EQ(vda.json()["agvPosition"]["x"], pose["x"]);
  EXPECT_EQ(vda.json()["agvPosition"]["localized"], true);
  EXPECT_THAT(vda.json()["errors"], IsEmpty());
  const std::string again = testing::session_batch(drive_, 9).dump();
  const Reply batch =
      client_.send("POST", "/v1/sessions/" + id + "/scans", again, "application/json",
                   {{"Accept", "application/json; profile=vda5050"}});
  EXPECT_EQ(batch.json()["agvPosition"], vda.json()["agvPosition"]);
}

TEST_F(SessionsApiTest, RefusesABatchWhenTheMapWasDeleted) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  post(id, 0);
  client_.remove("/v1/maps/office");
  const Reply reply = post(id, 1);
  EXPECT_EQ(reply.status, 409);
  EXPECT_THAT(reply.json()["detail"], HasSubstr("office"));
}

TEST_F(SessionsApiTest, ListsAndDeletes) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  const std::string other = testing::open_session(client_, "cart-8", "office");
  const Json last = post(id, 0).json();
  const Json list = client_.get("/v1/sessions").json()["sessions"];
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0]["id"], id);
  EXPECT_EQ(list[0]["status"], last["status"]);
  EXPECT_EQ(list[0]["last_answer"]["sequence"], 0);
  EXPECT_EQ(client_.remove("/v1/sessions/" + id).status, 204);
  EXPECT_EQ(client_.get("/v1/sessions/" + id).status, 404);
  EXPECT_EQ(client_.remove("/v1/sessions/" + id).status, 404);
  EXPECT_EQ(post(id, 1).status, 404);
  EXPECT_EQ(client_.get("/v1/sessions").json()["sessions"].size(), 1U);
}

TEST_F(SessionsApiTest, ShowsTheLastAnswerWithItsPoints) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  EXPECT_TRUE(client_.get("/v1/sessions/" + id).json()["last_answer"].is_null());
  post(id, 0);
  const Json answer = client_.get("/v1/sessions/" + id).json()["last_answer"];
  EXPECT_EQ(answer["scan_points"].size(), 360U);
  EXPECT_THAT(answer["feature_points"], ::testing::Not(IsEmpty()));
}

TEST_F(SessionsApiTest, KeepsTheAnswersSoFar) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  EXPECT_THAT(client_.get("/v1/sessions/" + id + "/history").json()["answers"], IsEmpty());
  Json last;
  for (std::uint64_t i = 0; i < 10; ++i) last = post(id, i).json();
  const Json answers = client_.get("/v1/sessions/" + id + "/history").json()["answers"];
  ASSERT_EQ(answers.size(), 10U);
  EXPECT_EQ(answers[0]["sequence"], 0);
  EXPECT_EQ(answers[9]["status"], last["status"]);
  EXPECT_EQ(answers[9]["pose"]["x"], last["pose"]["x"]);
  EXPECT_EQ(answers[9]["timing_ms"], last["timing_ms"]);
  EXPECT_EQ(client_.get("/v1/sessions/none/history").status, 404);
}

TEST_F(SessionsApiTest, SaysWhatTheProbabilityIsMadeOf) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  Json answer;
  for (std::uint64_t i = 0; i < 10; ++i) answer = post(id, i).json();
  ASSERT_EQ(answer["status"], "localized") << answer.dump(1);
  const Json& terms = answer["explanation"];
  EXPECT_GT(terms["explained_share"], 0.5);
  EXPECT_GT(terms["probability_explained"], 0.9);
  EXPECT_GT(terms["probability_best"], 0.9);
}

TEST_F(SessionsApiTest, AnswersASingleQuestion) {
  Json question = testing::session_batch(drive_, 0, 30);
  question.erase("sequence");
  question["lidar"] = testing::lidar_json();
  const Reply reply = client_.post("/v1/maps/office/localize", question);
  ASSERT_EQ(reply.status, 200) << reply.body;
  EXPECT_EQ(reply.json()["status"], "localized");
  EXPECT_TRUE(reply.json()["session"].is_null());
  EXPECT_THAT(client_.get("/v1/sessions").json()["sessions"], IsEmpty());
}

}  // namespace
}  // namespace cornerfix
