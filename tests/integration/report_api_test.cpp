// Localizability reports, against the real server.
#include <gmock/gmock.h>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using testing::Json;
using testing::Reply;
using ::testing::StartsWith;

class ReportApiTest : public ::testing::Test {
 protected:
  /// Waits for it, however slow this machine is.
  Reply get_report(const std::string& resource = "report") {
    for (;;) {
      Reply reply = client_.get("/v1/maps/room/" + resource + "?wait=60");
      if (reply.status != 202) return reply;
    }
  }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  testing::HttpClient client_{server_.port()};
};

TEST_F(ReportApiTest, TellsOfEveryPlaceOfTheMap) {
  testing::make_room_map(client_, "room");
  const Reply reply = get_report();
  ASSERT_EQ(reply.status, 200) << reply.body;
  const Json report = reply.json();
  EXPECT_EQ(report["revision"], client_.get("/v1/maps/room").json()["revision"]);
  EXPECT_EQ(report["state"], "done");
  EXPECT_EQ(report["lidar"]["beams"], 360) << "the map's own lidar";
  ASSERT_GE(report["places"].size(), 8U);
  for (const Json& place : report["places"]) {
    EXPECT_GT(place["x"].get<double>(), 0.0);
    EXPECT_LT(place["x"].get<double>(), 10.0);
    EXPECT_EQ(place["starts"].size(), 4U);
  }
  EXPECT_THAT(report["summary"].get<std::string>(), HasSubstr("are told their pose"));
  EXPECT_FALSE(report["advice"].empty());
}

TEST_F(ReportApiTest, SaysThatItIsBeingMadeToThoseWhoDoNotWait) {
  testing::make_room_map(client_, "room");
  const Reply reply = client_.get("/v1/maps/room/report?wait=0");
  ASSERT_EQ(reply.status, 202) << reply.body;
  EXPECT_EQ(reply.json()["state"], "computing");
  EXPECT_EQ(reply.header("retry-after"), "1");
  ASSERT_EQ(get_report().status, 200);
  EXPECT_EQ(client_.get("/v1/maps/room/report?wait=0").status, 200) << "kept";
}

TEST_F(ReportApiTest, IsMadeAnewWhenTheMapHasChanged) {
  testing::make_room_map(client_, "room");
  const Json before = get_report().json();
  const auto more = testing::mapping_drive(900.0);
  ASSERT_EQ(client_.post("/v1/maps/room/scans", testing::map_batch(more, 0, 20)).status, 200);
  const Json after = get_report().json();
  EXPECT_GT(after["revision"], before["revision"]);
  EXPECT_EQ(after["revision"], client_.get("/v1/maps/room").json()["revision"]);
}

TEST_F(ReportApiTest, IsDrawnOverTheGrid) {
  testing::make_room_map(client_, "room");
  const Reply picture = get_report("report.svg");
  ASSERT_EQ(picture.status, 200) << picture.body;
  EXPECT_THAT(picture.header("content-type"), StartsWith("image/svg+xml"));
  EXPECT_THAT(picture.body, StartsWith("<svg"));
  EXPECT_THAT(picture.body, HasSubstr("data:image/png;base64,iVBORw0KGgo"));
  EXPECT_THAT(picture.body, HasSubstr("<circle"));
}

TEST_F(ReportApiTest, IsRefusedWhereThereIsNothingToTell) {
  EXPECT_EQ(get_report().status, 404) << "no such map";
  ASSERT_EQ(client_.send("PUT", "/v1/maps/room", "{}", "application/json").status, 201);
  EXPECT_EQ(get_report().status, 404) << "an empty map";
  const Reply reply = client_.get("/v1/maps/room/report?wait=soon");
  EXPECT_EQ(reply.status, 422);
  EXPECT_THAT(reply.body, HasSubstr("wait"));
}

}  // namespace
}  // namespace cornerfix
