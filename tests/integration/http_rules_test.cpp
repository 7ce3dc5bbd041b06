// What holds for every call: paths, methods, bodies, limits, headers, connections.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <deque>

#include "integration/test_server.hpp"
#include "support/gzip.hpp"

namespace cornerfix {
namespace {

using ::testing::AllOf;
using testing::exchange_bytes;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Json;
using ::testing::Not;
using testing::Reply;
using ::testing::StartsWith;

constexpr std::size_t kMaxBody = 100'000;

server::ServerConfig small_limits() {
  server::ServerConfig config;
  config.max_body_bytes = kMaxBody;
  config.request_limits = {.max_scans = 4, .max_beams = 1000};
  return config;
}

class HttpRulesTest : public ::testing::Test {
 protected:
  static void expect_problem(const Reply& reply, int status) {
    EXPECT_EQ(reply.status, status) << reply.body;
    EXPECT_EQ(reply.header("content-type"), "application/problem+json");
    const Json problem = reply.json();
    EXPECT_EQ(problem["status"], status);
    for (const char* member : {"type", "title", "detail", "code"}) {
      EXPECT_THAT(problem[member].get<std::string>(), Not(IsEmpty())) << member;
    }
  }
  /// On a connection of its own, which the server is asked to close.
  std::string raw(const std::string& head, const std::string& body = "") const {
    return exchange_bytes(server_.port(), head + "Connection: close\r\n\r\n" + body);
  }
  [[nodiscard]] bool is_alive() { return client_.get("/healthz").status == 200; }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db", small_limits()};
  testing::HttpClient client_{server_.port()};
};

TEST_F(HttpRulesTest, KnowsUnknownPaths) {
  for (const char* path : {"/v1", "/v1/", "/v2/maps", "/v1/maps/", "/v1/sessions/", "/v1/maps/a/",
                           "/v1/maps/a/none", "/none", "/v1//maps", "/%zz", "/v1/maps/a%2Fscans"}) {
    expect_problem(client_.get(path), 404);
  }
  expect_problem(client_.post("/v1/maps/a/scans/", Json::object()), 404);
}

TEST_F(HttpRulesTest, SaysWhichMethodsAPathTakes) {
  const Reply reply = client_.send("PATCH", "/v1/maps", "{}", "application/json");
  expect_problem(reply, 405);
  EXPECT_EQ(reply.header("allow"), "GET, HEAD");
  const std::vector<std::pair<const char*, const char*>> wrong = {{"DELETE", "/v1/maps"},
                                                                  {"POST", "/v1/maps/a"},
                                                                  {"GET", "/v1/maps/a/scans"},
                                                                  {"POST", "/v1/maps/a/trajectory"},
                                                                  {"PUT", "/v1/sessions"},
                                                                  {"POST", "/v1/sessions/a"},
                                                                  {"GET", "/v1/sessions/a/reset"},
                                                                  {"PUT", "/v1/sessions/a/scans"},
                                                                  {"POST", "/healthz"},
                                                                  {"DELETE", "/metrics"},
                                                                  {"POST", "/"},
                                                                  {"OPTIONS", "/v1/maps"}};
  for (const auto& [method, path] : wrong) {
    const Reply refused = client_.send(method, path, "", "");
    expect_problem(refused, 405);
    EXPECT_THAT(refused.header("allow"), Not(IsEmpty())) << path;
  }
}

TEST_F(HttpRulesTest, RefusesOtherMediaTypes) {
  for (const char* type : {"application/x-www-form-urlencoded", "text/plain",
                           "multipart/form-data; boundary=x", "application/xml"}) {
    const Reply reply = client_.send("POST", "/v1/sessions", "{}", type);
    expect_problem(reply, 415);
    EXPECT_THAT(reply.json()["detail"], HasSubstr("application/json"));
  }
  const Reply large = client_.send("POST", "/v1/sessions", std::string(20'000, 'x'),
                                   "application/x-www-form-urlencoded");
  expect_problem(large, 415);
  EXPECT_THAT(large.json()["detail"], HasSubstr("curl"));
  expect_problem(client_.send("POST", "/v1/sessions", "{}", "application/json",
                              {{"Content-Encoding", "zstd"}}),
                 415);
}

TEST_F(HttpRulesTest, TakesGzip) {
  const Reply reply = client_.send("PUT", "/v1/maps/office", testing::gzipped("{}"),
                                   "application/json", {{"Content-Encoding", "gzip"}});
  EXPECT_EQ(reply.status, 201) << reply.body;
}

TEST_F(HttpRulesTest, RefusesBrokenGzip) {
  for (const std::string& body : {std::string("{}"), testing::gzipped("{}").substr(0, 15)}) {
    expect_problem(client_.send("PUT", "/v1/maps/office", body, "application/json",
                                {{"Content-Encoding", "gzip"}}),
                   400);
  }
  EXPECT_EQ(client_.get("/v1/maps/office").status, 404);
}

TEST_F(HttpRulesTest, LimitsABodyByLength) {
  expect_problem(
      client_.send("PUT", "/v1/maps/office", std::string(kMaxBody + 1, ' '), "application/json"),
      413);
  const std::string fits = R"({"description": ")" + std::string(100, 'x') + "\"}";
  testing::HttpClient other(server_.port());  // The refused request ended its connection.
  const Reply reply = other.send("PUT", "/v1/maps/office", fits, "application/json");
  EXPECT_EQ(reply.status, 201) << reply.body;
}

TEST_F(HttpRulesTest, LimitsABodyWhateverItPromises) {
  const std::string answer = exchange_bytes(
      server_.port(),
      "PUT /v1/maps/office HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Content-Length: 99999999999999\r\n\r\n");
  EXPECT_THAT(answer, AllOf(StartsWith("HTTP/1.1 413"), HasSubstr("Connection: close")));
}

TEST_F(HttpRulesTest, LimitsABodyInChunks) {
  expect_problem(
      client_.post_chunked("/v1/sessions", std::string(3 * kMaxBody, ' '), "application/json"),
      413);
  EXPECT_TRUE(is_alive());
}

TEST_F(HttpRulesTest, TakesABodyInChunks) {
  const std::string body = R"({"robot": "a", "map": "none", "lidar": )" +
                           testing::lidar_json().dump() + std::string(25'000, ' ') + "}";
  expect_problem(client_.post_chunked("/v1/sessions", body, "application/json"), 404);
}

TEST_F(HttpRulesTest, LimitsABodyAfterInflating) {
  const std::string bomb = testing::gzipped(std::string(60'000'000, ' '));
  ASSERT_LT(bomb.size(), kMaxBody);
  expect_problem(client_.send("PUT", "/v1/maps/office", bomb, "application/json",
                              {{"Content-Encoding", "gzip"}}),
                 413);
  EXPECT_TRUE(is_alive());
}

TEST_F(HttpRulesTest, LimitsScansAndBeams) {
  const std::string id = (client_.put("/v1/maps/office", Json::object()),
                          testing::open_session(client_, "cart-7", "office"));
  const auto drive = testing::robot_drive();
  EXPECT_EQ(
      client_.post("/v1/sessions/" + id + "/scans", testing::session_batch(drive, 0, 5)).status,
      413);
  Json batch = testing::session_batch(drive, 0, 1);
  batch["scans"][0]["ranges"] = std::vector<int>(1001, 1);
  EXPECT_EQ(client_.post("/v1/sessions/" + id + "/scans", batch).status, 413);
}

TEST_F(HttpRulesTest, NeedsALengthForADocument) {
  EXPECT_THAT(
      raw("POST /v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"),
      StartsWith("HTTP/1.1 411"));
}

TEST_F(HttpRulesTest, RefusesABodyWhoseEndIsInDoubt) {
  for (const char* framing :
       {"Content-Length: 2\r\nTransfer-Encoding: chunked\r\n", "Content-Length: two\r\n",
        "Content-Length: -2\r\n", "Content-Length: 2\r\nContent-Length: 3\r\n",
        "Transfer-Encoding: gzip, chunked\r\n"}) {
    const std::string answer = exchange_bytes(
        server_.port(), std::string("PUT /v1/maps/office HTTP/1.1\r\nHost: localhost\r\n") +
                            framing + "\r\n{}DELETE /v1/maps/other HTTP/1.1\r\n\r\n");
    EXPECT_THAT(answer, AllOf(StartsWith("HTTP/1.1 400"), HasSubstr("Connection: close")))
        << framing;
    EXPECT_THAT(answer.substr(10), Not(HasSubstr("HTTP/1.1 "))) << framing;
  }
}

TEST_F(HttpRulesTest, NeverTakesABodyForTheNextRequest) {
  client_.put("/v1/maps/office", Json::object());
  const std::string hidden = "DELETE /v1/maps/office HTTP/1.1\r\nHost: localhost\r\n\r\n";
  for (const char* request :
       {"GET /healthz", "HEAD /healthz", "GET /v1/none", "POST /v1/none", "POST /healthz",
        "OPTIONS /v1/maps", "PATCH /v1/maps/office", "DELETE /v1/maps/none"}) {
    raw(std::string(request) + " HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
            std::to_string(hidden.size()) + "\r\n",
        hidden);
    EXPECT_EQ(client_.get("/v1/maps/office").status, 200) << request;
  }
}

TEST_F(HttpRulesTest, RefusesARequestThatAProxyCouldReadDifferently) {
  client_.put("/v1/maps/office", Json::object());
  const std::string hidden = "DELETE /v1/maps/office HTTP/1.1\r\nHost: localhost\r\n\r\n";
  const std::string length = std::to_string(hidden.size());
  const std::string post = "POST /v1/none HTTP/1.1\r\nHost: localhost\r\n";
  const std::string chunked = "Transfer-Encoding: chunked\r\n";
  for (const std::string& head :
       {post + "Content-Length : " + length + "\r\n\r\n",
        post + "X-A: b\r\n Content-Length: " + length + "\r\n\r\n",
        "POST /v1/none HTTP/1.1\nHost: a\nContent-Length: " + length + "\n\n",
        post + chunked + chunked + "\r\n0\r\n\r\n",
        post + chunked + "Content-Length: " + length + "\r\n\r\n0\r\n\r\n",
        post + chunked + "\r\n+0\r\n\r\n",
        "HEAD /healthz HTTP/1.1\r\nHost: localhost\r\nContent-Length: " + length + "\r\n\r\n",
        "GET /healthz HTTP/1.1\r\nHost: localhost\r\n" + chunked + "\r\n0\r\n\r\n"}) {
    const std::string answer = exchange_bytes(server_.port(), head + hidden);
    EXPECT_THAT(answer, AllOf(StartsWith("HTTP/1.1 400"), HasSubstr("Connection: close"),
                              HasSubstr("application/problem+json")))
        << head;
    EXPECT_THAT(answer.substr(10), Not(HasSubstr("HTTP/1.1 "))) << head;
    EXPECT_EQ(client_.get("/v1/maps/office").status, 200) << head;
  }
}

TEST_F(HttpRulesTest, LimitsHeadersAndTrailers) {
  std::string lines;
  for (int i = 0; i < 200; ++i) lines += "x:y\r\n";
  EXPECT_THAT(raw("GET /healthz HTTP/1.1\r\nHost: localhost\r\n" + lines),
              AllOf(StartsWith("HTTP/1.1 431"), HasSubstr("headers_too_large")));
  std::string large;
  for (int i = 0; i < 10; ++i) large += "x: " + std::string(8000, 'y') + "\r\n";
  EXPECT_THAT(raw("GET /healthz HTTP/1.1\r\nHost: localhost\r\n" + large),
              StartsWith("HTTP/1.1 431"));
  const std::string trailers = exchange_bytes(
      server_.port(),
      "PUT /v1/maps/office HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n" +
          lines + "\r\n");
  EXPECT_THAT(trailers, StartsWith("HTTP/1.1 4"));
  EXPECT_EQ(client_.get("/v1/maps/office").status, 404);
}

TEST_F(HttpRulesTest, KeepsTheConnectionAfterAnError) {
  testing::RawConnection connection(server_.port());
  connection.send("POST /v1/none HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n12345");
  EXPECT_THAT(connection.read_until("}"), StartsWith("HTTP/1.1 404"));
  connection.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(connection.read_until("}"), StartsWith("HTTP/1.1 200"));
}

TEST_F(HttpRulesTest, AnswersRequestsThatWereSentTogether) {
  const std::string answers =
      exchange_bytes(server_.port(),
                     "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
                     "GET /v1/none HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(answers, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answers, HasSubstr("HTTP/1.1 404"));
}

TEST_F(HttpRulesTest, RefusesWhatIsNoHttpWithAProblem) {
  const std::string answer = exchange_bytes(server_.port(), "HELLO\r\n\r\n");
  EXPECT_THAT(answer, AllOf(StartsWith("HTTP/1.1 400"), HasSubstr("application/problem+json")));
  const std::string long_line =
      exchange_bytes(server_.port(), "GET /" + std::string(9000, 'a') + " HTTP/1.1\r\n\r\n");
  EXPECT_THAT(long_line, AllOf(StartsWith("HTTP/1.1 414"), HasSubstr("uri_too_long"),
                               Not(HasSubstr("X-Request-Id: \r\n"))));
  const std::string long_header = exchange_bytes(
      server_.port(), "GET /healthz HTTP/1.1\r\nX-Long: " + std::string(9000, 'a') + "\r\n\r\n");
  EXPECT_THAT(long_header, AllOf(StartsWith("HTTP/1.1 431"), HasSubstr("headers_too_large")));
  EXPECT_THAT(raw("GET /" + std::string(5000, 'a') + " HTTP/1.1\r\nHost: localhost\r\n"),
              StartsWith("HTTP/1.1 414"));
  EXPECT_TRUE(is_alive());
}

TEST_F(HttpRulesTest, RefusesManyRangesAndIgnoresOne) {
  expect_problem(client_.get("/", {{"Range", "bytes=0-,0-"}}), 416);
  const Reply whole = client_.get("/", {{"Range", "bytes=0-3"}});
  EXPECT_EQ(whole.status, 200);
  EXPECT_GT(whole.body.size(), 4U);
}

TEST_F(HttpRulesTest, RefusesAnotherSitesPage) {
  expect_problem(client_.send("PUT", "/v1/maps/office", "{}", "application/json",
                              {{"Sec-Fetch-Site", "cross-site"}}),
                 403);
  EXPECT_EQ(client_
                .send("PUT", "/v1/maps/office", "{}", "application/json",
                      {{"Sec-Fetch-Site", "same-origin"}})
                .status,
            201);
}

TEST_F(HttpRulesTest, KnowsItsNamesAndRefusesOthers) {
  const std::string answer = exchange_bytes(
      server_.port(),
      "GET /v1/maps HTTP/1.1\r\nHost: evil.example.com\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(answer, AllOf(StartsWith("HTTP/1.1 421"), HasSubstr("allowed_hosts")));
  expect_problem(client_.send("PUT", "/v1/maps/office", "{}", "application/json",
                              {{"Origin", "http://evil.example.com"}}),
                 403);
  const std::string own = "http://127.0.0.1:" + std::to_string(server_.port());
  expect_problem(client_.send("PUT", "/v1/maps/office", "{}", "application/json",
                              {{"Origin", own}, {"Origin", "http://evil.example.com"}}),
                 403);
  EXPECT_EQ(
      client_.send("PUT", "/v1/maps/office", "{}", "application/json", {{"Origin", own}}).status,
      201);
}

TEST_F(HttpRulesTest, PutsSafeHeadersOnEveryAnswer) {
  for (const char* path : {"/", "/healthz", "/none", "/v1/maps"}) {
    const Reply reply = client_.get(path);
    EXPECT_EQ(reply.header("x-content-type-options"), "nosniff") << path;
    EXPECT_THAT(reply.header("content-security-policy"), HasSubstr("default-src 'self'")) << path;
    EXPECT_THAT(reply.header("x-request-id"), Not(IsEmpty())) << path;
    EXPECT_THAT(reply.header("cache-control"), Not(IsEmpty())) << path;
    EXPECT_THAT(reply.header("vary"), HasSubstr("Accept")) << path;
  }
}

TEST_F(HttpRulesTest, ServesTheInspectorsFiles) {
  const Reply page = client_.get("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.header("content-type"), StartsWith("text/html"));
  EXPECT_EQ(client_.get("/", {{"If-None-Match", page.header("etag")}}).status, 304);
  EXPECT_EQ(client_.get("/app.js").status, 200);
  EXPECT_EQ(client_.get("/favicon.ico").header("content-type"), "image/svg+xml");
  EXPECT_EQ(client_.get("/vendor/leaflet/leaflet.css").status, 200);
  expect_problem(client_.get("/../CMakeLists.txt"), 404);
  expect_problem(client_.get("/%2e%2e/CMakeLists.txt"), 404);
}

TEST_F(HttpRulesTest, AnswersHeadWithoutABody) {
  const std::string answer = raw("HEAD /healthz HTTP/1.1\r\nHost: localhost\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, ::testing::EndsWith("\r\n\r\n"));
}

TEST_F(HttpRulesTest, TellsItsHealthAndItsNumbers) {
  EXPECT_EQ(client_.get("/healthz").status, 200);
  EXPECT_EQ(client_.get("/readyz").status, 200);
  client_.get("/v1/maps/none");
  const Reply metrics = client_.get("/metrics");
  EXPECT_THAT(metrics.header("content-type"), StartsWith("text/plain"));
  EXPECT_THAT(metrics.body, HasSubstr("cornerfix_http_requests_total{method=\"GET\",route=\"/v1/"
                                      "maps/{map}\",status=\"404\"} 1"));
}

TEST_F(HttpRulesTest, TakesOverTheNamesOfARequest) {
  const std::string trace = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
  const Reply reply =
      client_.get("/healthz", {{"X-Request-Id", "robot-7.42"}, {"traceparent", trace}});
  EXPECT_EQ(reply.header("x-request-id"), "robot-7.42");
  EXPECT_EQ(reply.header("traceparent"), trace);
  const Reply odd = client_.get("/healthz", {{"X-Request-Id", "a b"}, {"traceparent", "00-1"}});
  EXPECT_NE(odd.header("x-request-id"), "a b");
  EXPECT_NE(odd.header("x-request-id"), "");
  EXPECT_EQ(odd.header("traceparent"), "");
}

TEST_F(HttpRulesTest, SaysInItsMetricsWhatItUses) {
  client_.get("/healthz");
  const std::string metrics = client_.get("/metrics").body;
  for (const char* name : {"cornerfix_connections 1", "cornerfix_requests_in_work 1",
                           "cornerfix_build_info{version=", "\nprocess_resident_memory_bytes ",
                           "\ncornerfix_disk_free_bytes "}) {
    EXPECT_THAT(metrics, HasSubstr(name));
  }
}

TEST_F(HttpRulesTest, ServesRobotsBesideClientsThatHoldTheirConnections) {
  server::ServerConfig config;
  config.worker_threads = 1;
  testing::TestServer server(directory_ / "beside.db", config);
  std::deque<testing::RawConnection> hostile;
  for (int i = 0; i < 100; ++i) {
    hostile.emplace_back(server.port()).send(i % 2 == 0 ? "" : "GET /healthz HTTP/1.1\r\nHos");
    // Bodies that never come.
    hostile.emplace_back(server.port())
        .send("PUT /v1/maps/office HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000\r\n\r\n{");
  }
  testing::HttpClient robot(server.port());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(robot.get("/v1/maps").status, 200);
  }
}

TEST_F(HttpRulesTest, RefusesLargeBodiesWithoutReadingThem) {
  server::ServerConfig config;
  config.max_requests_in_work = 1;
  config.tokens = {{"0123456789abcdef", server::Role::kAdmin, "me"}};
  testing::TestServer server(directory_ / "tokens.db", config);
  testing::RawConnection stranger(server.port());
  stranger.send(
      "POST /v1/maps/office/archive HTTP/1.1\r\nHost: localhost\r\nContent-Length: "
      "200000000\r\n\r\n");
  EXPECT_THAT(stranger.read_to_end(),
              AllOf(StartsWith("HTTP/1.1 401"), HasSubstr("Connection: close")));
}

TEST_F(HttpRulesTest, TakesALargeBodyAfterAskingForIt) {
  server::ServerConfig config;
  testing::TestServer server(directory_ / "large.db", config);
  const std::string body = "{" + std::string(3'000'000, ' ') + "}";
  testing::RawConnection client(server.port());
  client.send(
      "PUT /v1/maps/office HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Expect: 100-continue\r\nConnection: close\r\nContent-Length: " +
      std::to_string(body.size()) + "\r\n\r\n");
  EXPECT_THAT(client.read_until("\r\n\r\n"), StartsWith("HTTP/1.1 100"));
  client.send(body);
  EXPECT_THAT(client.read_to_end(), StartsWith("HTTP/1.1 201"));
  testing::HttpClient again(server.port());
  EXPECT_EQ(again.post_chunked("/v1/sessions", body, "application/json").status, 422);
}

TEST_F(HttpRulesTest, IsNotReadyWithoutItsDatabaseOrRoomForIt) {
  server::ServerConfig config;
  config.min_free_bytes = std::size_t{1} << 60U;
  testing::TestServer full(directory_ / "full.db", config);
  const Reply no_room = testing::HttpClient(full.port()).get("/readyz");
  expect_problem(no_room, 503);
  EXPECT_THAT(no_room.json()["detail"], HasSubstr("bytes left"));
  std::filesystem::remove(directory_ / "test.db");
  expect_problem(client_.put("/v1/maps/office", Json::object()), 503);
  const Reply deleted = client_.get("/readyz");
  expect_problem(deleted, 503);
  EXPECT_THAT(deleted.json()["detail"], HasSubstr("deleted or replaced"));
  EXPECT_TRUE(is_alive());
}

TEST_F(HttpRulesTest, AcknowledgesNothingWithoutItsWriteAheadLog) {
  ASSERT_TRUE(std::filesystem::remove(directory_ / "test.db-wal"));
  expect_problem(client_.put("/v1/maps/office", Json::object()), 503);
  expect_problem(client_.post("/v1/sessions", testing::session_request("cart-7", nullptr)), 503);
  expect_problem(client_.get("/readyz"), 503);
  EXPECT_TRUE(is_alive());
}

TEST_F(HttpRulesTest, LeavesDescriptorsToTheDatabase) {
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
  rlimit low = limit;
  low.rlim_cur = 129;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  testing::TestServer server(directory_ / "low.db");
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  testing::RawConnection holder(server.port());
  testing::RawConnection second(server.port());
  EXPECT_THAT(second.read_to_end(), StartsWith("HTTP/1.1 503"));
}

TEST_F(HttpRulesTest, TurnsConnectionsAwayAboveItsLimit) {
  server::ServerConfig config;
  config.max_connections = 1;
  testing::TestServer busy(directory_ / "busy.db", config);
  testing::RawConnection holder(busy.port());
  testing::RawConnection second(busy.port());
  EXPECT_THAT(second.read_to_end(), AllOf(StartsWith("HTTP/1.1 503"), HasSubstr("Retry-After: 1"),
                                          HasSubstr("application/problem+json")));
}

}  // namespace
}  // namespace cornerfix
