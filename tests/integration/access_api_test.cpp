// Who may do what, when the server has tokens.
#include <gmock/gmock.h>

#include "integration/test_server.hpp"
#include "storage/database.hpp"
#include "storage/token_store.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using testing::HttpClient;
using testing::Json;
using testing::Reply;

server::ServerConfig with_tokens() {
  server::ServerConfig config;
  config.tokens = {{"viewer-token-0123", server::Role::kViewer, "desk"},
                   {"robot7-token-0123", server::Role::kRobot, "cart-7"},
                   {"robot8-token-0123", server::Role::kRobot, "cart-8"},
                   {"admin-token-01234", server::Role::kAdmin, "boss"}};
  return config;
}

class AccessApiTest : public ::testing::Test {
 protected:
  AccessApiTest() {
    admin_.set_header("Authorization", "Bearer admin-token-01234");
    viewer_.set_header("Authorization", "Bearer viewer-token-0123");
    robot_.set_header("Authorization", "Bearer robot7-token-0123");
    other_robot_.set_header("Authorization", "Bearer robot8-token-0123");
    admin_.put("/v1/maps/office", {{"lidar", testing::lidar_json()}});
  }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db", with_tokens()};
  HttpClient nobody_{server_.port()};
  HttpClient admin_{server_.port()};
  HttpClient viewer_{server_.port()};
  HttpClient robot_{server_.port()};
  HttpClient other_robot_{server_.port()};
};

TEST_F(AccessApiTest, AsksForAToken) {
  for (const char* path : {"/v1/maps", "/v1/sessions", "/v1/maps/office", "/metrics"}) {
    const Reply reply = nobody_.get(path);
    EXPECT_EQ(reply.status, 401) << path;
    EXPECT_THAT(reply.header("www-authenticate"), HasSubstr("Bearer"));
    EXPECT_EQ(reply.header("content-type"), "application/problem+json");
  }
  nobody_.set_header("Authorization", "Bearer wrong-token-01234");
  EXPECT_EQ(nobody_.get("/v1/maps").status, 401);
  EXPECT_EQ(nobody_.put("/v1/maps/mine", Json::object()).status, 401);
}

TEST_F(AccessApiTest, LetsAnybodySeeHealthAndThePage) {
  for (const char* path : {"/healthz", "/readyz", "/"}) {
    EXPECT_EQ(nobody_.get(path).status, 200) << path;
  }
}

TEST_F(AccessApiTest, LetsAViewerReadOnly) {
  EXPECT_EQ(viewer_.get("/v1/maps/office").status, 200);
  EXPECT_EQ(viewer_.get("/v1/sessions").status, 200);
  EXPECT_EQ(viewer_.put("/v1/maps/office", Json::object()).status, 403);
  EXPECT_EQ(viewer_.remove("/v1/maps/office").status, 403);
  EXPECT_EQ(viewer_.post("/v1/sessions", testing::session_request("desk", "office")).status, 403);
  EXPECT_EQ(viewer_.post("/v1/maps/office/localize", Json::object()).status, 403);
}

TEST_F(AccessApiTest, LetsARobotRunItsOwnSessionsOnly) {
  EXPECT_EQ(robot_.put("/v1/maps/mine", Json::object()).status, 403);
  EXPECT_EQ(robot_.post("/v1/maps/office/scans", Json::object()).status, 403);
  EXPECT_EQ(robot_.post("/v1/sessions", testing::session_request("cart-8", "office")).status, 403);
  const std::string id = testing::open_session(robot_, "cart-7", "office");
  const std::string path = "/v1/sessions/" + id;
  const auto batch = testing::session_batch(testing::robot_drive(3), 0);
  EXPECT_EQ(other_robot_.get(path).status, 403);
  EXPECT_EQ(other_robot_.post(path + "/scans", batch).status, 403);
  EXPECT_EQ(other_robot_.send("POST", path + "/reset", "", "").status, 403);
  EXPECT_EQ(other_robot_.get(path + "/events").status, 403);
  EXPECT_EQ(other_robot_.remove(path).status, 403);
  EXPECT_TRUE(other_robot_.get("/v1/sessions").json()["sessions"].empty());
  EXPECT_EQ(robot_.post(path + "/scans", batch).status, 200);
  EXPECT_EQ(robot_.get("/v1/sessions").json()["sessions"].size(), 1U);
  EXPECT_EQ(robot_.send("POST", path + "/reset", "", "").status, 200);
  EXPECT_EQ(robot_.remove(path).status, 204);
}

TEST_F(AccessApiTest, LetsAnAdminDoAll) {
  const std::string id = testing::open_session(robot_, "cart-7", "office");
  EXPECT_EQ(viewer_.get("/v1/sessions/" + id).status, 200);
  EXPECT_EQ(admin_.remove("/v1/sessions/" + id).status, 204);
  EXPECT_EQ(admin_.remove("/v1/maps/office").status, 204);
}

/// Tokens in the database, made and revoked by another process.
class StoredTokensTest : public AccessApiTest {
 protected:
  HttpClient holder_of(storage::TokenRecord record) {
    const std::string token = "cfx_" + record.name + record.role;
    record.hash = storage::hash_of_token(token);
    id_ = tokens_.insert(record).value();
    HttpClient client(server_.port());
    client.set_header("Authorization", "Bearer " + token);
    return client;
  }

  storage::TokenStore tokens_{
      storage::Database::open(directory_ / "test.db", storage::Synchronous::kNormal).value()};
  std::int64_t id_ = 0;
};

TEST_F(StoredTokensTest, AreGoodAtOnceAndUselessOnceRevoked) {
  HttpClient viewer = holder_of({.name = "desk", .role = "viewer"});
  EXPECT_EQ(viewer.get("/v1/maps").status, 200);
  EXPECT_EQ(viewer.put("/v1/maps/mine", Json::object()).status, 403);
  ASSERT_TRUE(tokens_.remove(id_));
  EXPECT_EQ(viewer.get("/v1/maps").status, 401);
}

TEST_F(StoredTokensTest, ExpireByTheirDate) {
  EXPECT_EQ(holder_of({.name = "old", .role = "admin", .expires = "2001-01-01T00:00:00Z"})
                .get("/v1/maps")
                .status,
            401);
}

TEST_F(StoredTokensTest, LetAMapperChangeMapsOnly) {
  HttpClient mapper = holder_of({.name = "mapper", .role = "mapper"});
  EXPECT_EQ(mapper.put("/v1/maps/mine", Json::object()).status, 201);
  EXPECT_EQ(mapper.remove("/v1/maps/mine").status, 204);
  EXPECT_EQ(mapper.post("/v1/sessions", testing::session_request("mapper", "office")).status, 403);
}

TEST_F(StoredTokensTest, KeepARobotToItsMaps) {
  admin_.put("/v1/maps/secret", {{"lidar", testing::lidar_json()}});
  HttpClient robot = holder_of({.name = "cart-9", .role = "robot", .maps = {"office"}});
  EXPECT_EQ(robot.post("/v1/sessions", testing::session_request("cart-9", "secret")).status, 403);
  EXPECT_EQ(robot.post("/v1/maps/secret/localize", Json::object()).status, 403);
  const Reply any = robot.post("/v1/sessions", testing::session_request("cart-9", nullptr));
  ASSERT_EQ(any.status, 201);
  EXPECT_EQ(any.json()["maps"], Json::array({"office"}));
}

TEST_F(StoredTokensTest, CloseAServerThatWasOpen) {
  testing::TestServer open(directory_ / "open.db");
  HttpClient anybody(open.port());
  EXPECT_EQ(anybody.get("/v1/maps").status, 200);
  storage::TokenStore tokens(
      storage::Database::open(directory_ / "open.db", storage::Synchronous::kNormal).value());
  const auto id = tokens.insert({.name = "desk", .role = "viewer"});
  EXPECT_EQ(anybody.get("/v1/maps").status, 401);
  ASSERT_TRUE(tokens.remove(*id));  // It does not open again by itself.
  EXPECT_EQ(anybody.get("/v1/maps").status, 401);
}

}  // namespace
}  // namespace cornerfix
