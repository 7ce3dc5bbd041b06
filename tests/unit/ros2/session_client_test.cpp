#include "ros2/session_client.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "support/fake_server.hpp"

namespace cornerfix::ros2 {
namespace {

using ::testing::ElementsAre;
using testing::FakeAnswer;
using testing::FakeRequest;
using testing::FakeServer;
using ::testing::HasSubstr;
using Json = nlohmann::json;
using Kind = SessionClient::Outcome::Kind;

constexpr const char* kCollecting =
    R"({"session": "abc", "status": "collecting", "reason": "no_motion", "confidence": 0.1,
        "pose": null})";

std::vector<AssembledScan> scans(bool begins_run = false) {
  AssembledScan scan;
  scan.scan = {1.5, -1.0, 0.5, 0.1, 10.0, {1.0F, std::numeric_limits<float>::infinity()}};
  scan.T_base_link_laser = {0.3, 0.0, 0.1};
  scan.T_odom_base_link = Pose2{1.0, 2.0, 0.5};
  scan.begins_run = begins_run;
  return {scan};
}

/// Opens sessions, and answers batches with `on_batch`.
auto server_with(std::function<FakeAnswer()> on_batch) {
  return [on_batch = std::move(on_batch)](const FakeRequest& request) -> FakeAnswer {
    if (request.path == "/v1/sessions") return {201, R"({"id": "abc"})"};
    return request.method == "DELETE" ? FakeAnswer{204, ""} : on_batch();
  };
}

std::uint64_t sequence_of(const FakeRequest& batch) {
  return Json::from_cbor(batch.body)["sequence"];
}

TEST(SessionClient, OpensASessionAndPostsScansAsCbor) {
  FakeServer server(server_with([] { return FakeAnswer{200, kCollecting}; }));
  SessionClient client({server.url(), "secret"}, {"robot-7", {"office"}});
  const auto outcome = client.post(scans());
  ASSERT_EQ(outcome.kind, Kind::kAnswered) << outcome.problem;
  EXPECT_EQ(outcome.answer->status, "collecting");
  EXPECT_EQ(outcome.answer->reason, "no_motion");
  EXPECT_FALSE(outcome.answer->pose);
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 2U);
  EXPECT_EQ(requests[0].authorization, "Bearer secret");
  const Json opening = Json::parse(requests[0].body);
  EXPECT_EQ(opening["robot"], "robot-7");
  EXPECT_EQ(opening["maps"], Json({"office"}));
  EXPECT_EQ(requests[1].path, "/v1/sessions/abc/scans");
  EXPECT_EQ(requests[1].content_type, "application/cbor");
  const Json batch = Json::from_cbor(requests[1].body);
  EXPECT_FALSE(opening.contains("lidars") || opening.contains("near"));
  EXPECT_EQ(batch["scans"][0]["mount"], Json({{"x", 0.3}, {"y", 0.0}, {"yaw", 0.1}}));
  EXPECT_EQ(batch["scans"][0]["odom"], Json({{"x", 1.0}, {"y", 2.0}, {"yaw", 0.5}}));
  EXPECT_EQ(batch["scans"][0]["ranges"][1], std::numeric_limits<double>::infinity());
}

TEST(SessionClient, NamesTheLidarsOfTheSessionAndOfEachScan) {
  FakeServer server(server_with([] { return FakeAnswer{200, kCollecting}; }));
  SessionClient client({server.url(), ""}, {"robot-7", {}, {"front", "rear"}});
  std::vector<AssembledScan> batch = scans();
  batch.front().lidar = "rear";
  ASSERT_EQ(client.post(batch).kind, Kind::kAnswered);
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 2U);
  const Json opening = Json::parse(requests[0].body);
  EXPECT_FALSE(opening.contains("lidar"));
  EXPECT_EQ(opening["lidars"].size(), 2U);
  EXPECT_TRUE(opening["lidars"].contains("front"));
  const Json scan = Json::from_cbor(requests[1].body)["scans"][0];
  EXPECT_EQ(scan["lidar"], "rear");
  EXPECT_EQ(scan["angle_min"], -1.0);
}

TEST(SessionClient, SendsWhereTheRobotIsSwitchedOnWithTheFirstSessionOnly) {
  FakeServer server(server_with([] { return FakeAnswer{200, kCollecting}; }));
  const StartRegion near{
      .center = {1.0, 2.0}, .radius_m = 3.0, .yaw = 0.5, .yaw_tolerance_rad = 0.8};
  SessionClient client({server.url(), ""}, {"robot-7", {}, {}, near});
  ASSERT_EQ(client.post(scans()).kind, Kind::kAnswered);
  ASSERT_EQ(client.post(scans(/*begins_run=*/true)).kind, Kind::kAnswered);
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 5U);
  EXPECT_EQ(
      Json::parse(requests[0].body)["near"],
      Json({{"x", 1.0}, {"y", 2.0}, {"radius_m", 3.0}, {"yaw", 0.5}, {"yaw_tolerance_rad", 0.8}}));
  EXPECT_FALSE(Json::parse(requests[3].body).contains("near")) << "it has moved since";
}

TEST(SessionClient, ReadsThePose) {
  FakeServer server(server_with([] {
    return FakeAnswer{200, R"({"session": "abc", "status": "localized", "reason": null,
        "confidence": 0.99, "pose": {"map": "office", "revision": 1, "stamp": 1.5, "x": 1.0,
        "y": 2.0, "yaw": 0.5, "covariance": [1, 2, 3, 4, 5, 6, 7, 8, 9], "epoch": 3,
        "confirmed": true}})"};
  }));
  SessionClient client({server.url(), ""}, {"robot-7", {}});
  const auto outcome = client.post(scans());
  ASSERT_TRUE(outcome.answer && outcome.answer->pose) << outcome.problem;
  EXPECT_EQ(outcome.answer->pose->T_map_base_link, (Pose2{1.0, 2.0, 0.5}));
  EXPECT_THAT(outcome.answer->pose->covariance, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(outcome.answer->pose->epoch, 3U);
  EXPECT_TRUE(outcome.answer->pose->is_confirmed);
}

TEST(SessionClient, PostsTheSameBatchAgainWhenTheServerIsBusy) {
  int calls = 0;
  FakeServer server(server_with([&] {
    return ++calls == 1 ? FakeAnswer{503, R"({"detail": "busy"})", "2"}
                        : FakeAnswer{200, kCollecting};
  }));
  SessionClient client({server.url(), ""}, {"robot-7", {}});
  const auto busy = client.post(scans());
  EXPECT_EQ(busy.kind, Kind::kTryAgain);
  EXPECT_EQ(busy.wait, std::chrono::seconds(2));
  EXPECT_EQ(busy.problem, "503 busy");
  EXPECT_EQ(client.post(scans()).kind, Kind::kAnswered);
  EXPECT_EQ(client.post(scans()).kind, Kind::kAnswered);
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 4U);
  EXPECT_EQ(sequence_of(requests[1]), 0U);
  EXPECT_EQ(sequence_of(requests[2]), 0U);
  EXPECT_EQ(sequence_of(requests[3]), 1U);
}

TEST(SessionClient, GoesOnWithTheSequenceThatTheServerExpects) {
  int calls = 0;
  FakeServer server(server_with([&] {
    return ++calls == 1
               ? FakeAnswer{409, R"({"code": "sequence_conflict", "detail": "", "expected": 39})"}
               : FakeAnswer{200, kCollecting};
  }));
  SessionClient client({server.url(), ""}, {"robot-7", {}});
  EXPECT_EQ(client.post(scans()).kind, Kind::kTryAgain);
  EXPECT_EQ(client.post(scans()).kind, Kind::kAnswered);
  EXPECT_EQ(sequence_of(server.requests()[2]), 39U);
}

TEST(SessionClient, OpensANewSessionWhenItsOwnIsGone) {
  for (const int status : {404, 409}) {
    int calls = 0;
    FakeServer server(server_with([&] {
      return ++calls == 1 ? FakeAnswer{status, R"({"detail": "gone"})"}
                          : FakeAnswer{200, kCollecting};
    }));
    SessionClient client({server.url(), ""}, {"robot-7", {}});
    EXPECT_EQ(client.post(scans()).kind, Kind::kTryAgain);
    EXPECT_EQ(client.post(scans()).kind, Kind::kAnswered);
    EXPECT_EQ(server.requests()[2].path, "/v1/sessions");
  }
}

TEST(SessionClient, OpensANewSessionForANewRun) {
  FakeServer server(server_with([] { return FakeAnswer{200, kCollecting}; }));
  SessionClient client({server.url(), ""}, {"robot-7", {}});
  EXPECT_EQ(client.post(scans()).kind, Kind::kAnswered);
  EXPECT_EQ(client.post(scans(/*begins_run=*/true)).kind, Kind::kAnswered);
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 5U);
  EXPECT_EQ(requests[2].method, "DELETE");
  EXPECT_EQ(requests[3].path, "/v1/sessions");
  EXPECT_EQ(sequence_of(requests[4]), 0U);
}

TEST(SessionClient, DropsABatchThatTheServerCannotTake) {
  FakeServer server(server_with([] {
    return FakeAnswer{422, R"({"detail": "must be a number", "errors":
        [{"pointer": "/scans/0/stamp", "detail": "must be a number"}]})"};
  }));
  SessionClient client({server.url(), ""}, {"robot-7", {}});
  const auto outcome = client.post(scans());
  EXPECT_EQ(outcome.kind, Kind::kRefused);
  EXPECT_EQ(outcome.problem, "422 must be a number (at /scans/0/stamp)");
}

TEST(SessionClient, WaitsLongerAndLongerForAServerThatDoesNotAnswer) {
  SessionClient client({"http://127.0.0.1:1", ""}, {"robot-7", {}});  // Nobody listens there.
  const auto first = client.post(scans());
  EXPECT_EQ(first.kind, Kind::kTryAgain);
  EXPECT_EQ(first.problem, "no answer from http://127.0.0.1:1");
  EXPECT_GT(client.post(scans()).wait, first.wait);
}

TEST(SessionClient, ChecksThatItsMapsExist) {
  FakeServer server([](const FakeRequest& request) {
    return request.path == "/v1/maps/office" ? FakeAnswer{200, "{}"}
                                             : FakeAnswer{404, R"({"detail": "no such map"})"};
  });
  EXPECT_FALSE(SessionClient({server.url(), ""}, {"robot-7", {"office"}}).check());
  const auto wrong = SessionClient({server.url(), ""}, {"robot-7", {"office", "offce"}}).check();
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->message, "404 no such map");
  EXPECT_THAT(wrong->field, HasSubstr("/v1/maps/offce"));
}

}  // namespace
}  // namespace cornerfix::ros2
