// What a client is refused before it takes the room of others, and how it gets out of it.
#include <SQLiteCpp/Database.h>
#include <gmock/gmock.h>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using testing::HttpClient;
using testing::Json;
using testing::Reply;

void expect_limited(const Reply& reply, const std::string& code) {
  EXPECT_EQ(reply.status, 429) << reply.body;
  EXPECT_EQ(reply.json()["code"], code);
  EXPECT_EQ(reply.header("retry-after"), "60");
}

TEST(QuotasApi, LimitMapsAndLetThoseThereAreChange) {
  const testing::TemporaryDirectory directory;
  server::ServerConfig config;
  config.max_maps = 1;
  const testing::TestServer server(directory / "test.db", config);
  HttpClient client(server.port());
  EXPECT_EQ(client.put("/v1/maps/office", Json::object()).status, 201);
  expect_limited(client.put("/v1/maps/lab", Json::object()), "too_many_maps");
  EXPECT_EQ(client.put("/v1/maps/office", {{"description", "new"}}).status, 200);
  EXPECT_EQ(client.remove("/v1/maps/office").status, 204);
  EXPECT_EQ(client.put("/v1/maps/lab", Json::object()).status, 201);
  EXPECT_THAT(client.get("/metrics").body,
              HasSubstr("cornerfix_requests_limited_total{reason=\"too_many_maps\"} 1"));
}

TEST(QuotasApi, LimitSessionsPerRobotAndInTotal) {
  const testing::TemporaryDirectory directory;
  server::ServerConfig config;
  config.max_sessions_per_robot = 1;
  config.max_sessions = 2;
  const testing::TestServer server(directory / "test.db", config);
  HttpClient client(server.port());
  const auto open = [&](const char* robot) {
    return client.post("/v1/sessions", testing::session_request(robot, nullptr));
  };
  EXPECT_EQ(open("cart-7").status, 201);
  expect_limited(open("cart-7"), "too_many_sessions");
  EXPECT_EQ(open("cart-8").status, 201);
  expect_limited(open("cart-9"), "too_many_sessions");
}

TEST(QuotasApi, LimitTheBytesOfTheDatabase) {
  const testing::TemporaryDirectory directory;
  server::ServerConfig config;
  config.max_database_bytes = 1;
  const testing::TestServer server(directory / "test.db", config);
  HttpClient client(server.port());
  expect_limited(client.put("/v1/maps/office", Json::object()), "database_full");
  expect_limited(client.post("/v1/sessions", testing::session_request("cart-7", nullptr)),
                 "database_full");
}

TEST(QuotasApi, AQueryParameterThatIsNotTakenIsNamed) {
  const testing::TemporaryDirectory directory;
  const testing::TestServer server(directory / "test.db");
  HttpClient client(server.port());
  const Reply reply = client.get("/v1/maps?lmit=3");
  EXPECT_EQ(reply.status, 422);
  EXPECT_EQ(reply.json()["errors"][0]["pointer"], "/lmit");
  EXPECT_THAT(reply.json()["detail"].get<std::string>(), HasSubstr("limit, page_token"));
  EXPECT_EQ(client.get("/v1/maps?limit=3").status, 200);
  EXPECT_EQ(client.get("/healthz?probe=1").status, 200);
}

TEST(DamagedSessionApi, IsNamedAndCanBeDeleted) {
  const testing::TemporaryDirectory directory;
  std::string path;
  {
    const testing::TestServer server(directory / "test.db");
    HttpClient client(server.port());
    path = "/v1/sessions/" + testing::open_session(client, "cart-7", nullptr);
  }
  SQLite::Database((directory / "test.db").string(), SQLite::OPEN_READWRITE)
      .exec("UPDATE sessions SET state = x'00'");
  const testing::TestServer server(directory / "test.db");
  HttpClient client(server.port());
  const Reply damaged = client.get(path);
  EXPECT_EQ(damaged.status, 500);
  EXPECT_EQ(damaged.json()["code"], "corrupt_data");
  EXPECT_THAT(damaged.json()["detail"].get<std::string>(), HasSubstr("delete the session"));
  EXPECT_EQ(client.get("/v1/sessions").json()["sessions"][0]["damaged"], true);
  EXPECT_EQ(client.remove(path).status, 204);
  EXPECT_EQ(client.get(path).status, 404);
}

}  // namespace
}  // namespace cornerfix
