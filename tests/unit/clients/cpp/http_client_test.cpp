#include "clients/cpp/http_client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <thread>
#include <vector>

#include "support/fake_server.hpp"

namespace cornerfix::client {
namespace {

using ::testing::HasSubstr;

HttpClient client_of(const testing::FakeServer& server, const std::string& token = "") {
  Result<HttpClient> client = HttpClient::create({server.url(), token});
  EXPECT_TRUE(client.ok());
  return std::move(*client);
}

TEST(HttpClient, SendsMethodPathBodyAndToken) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{200, R"({"ok": true})"};
  });
  HttpClient client = client_of(server, "secret");
  const auto body = client.send({"PUT", "/v1/maps/a?x=1", R"({"a": 1})"});
  ASSERT_TRUE(body.ok()) << body.error().message;
  EXPECT_EQ(*body, R"({"ok": true})");
  const auto requests = server.requests();
  ASSERT_EQ(requests.size(), 1U);
  EXPECT_EQ(requests[0].method, "PUT");
  EXPECT_EQ(requests[0].path, "/v1/maps/a?x=1");
  EXPECT_EQ(requests[0].body, R"({"a": 1})");
  EXPECT_EQ(requests[0].content_type, "application/json");
  EXPECT_EQ(requests[0].authorization, "Bearer secret");
}

TEST(HttpClient, BeginsEveryPathWithThatOfTheServer) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{204, ""};
  });
  Result<HttpClient> client = HttpClient::create({server.url() + "/robots/", ""});
  ASSERT_TRUE(client.ok());
  ASSERT_TRUE(client->send({"DELETE", "/v1/maps/a"}).ok());
  EXPECT_EQ(server.requests()[0].path, "/robots/v1/maps/a");
}

TEST(HttpClient, ReportsTheDetailOfAProblemDocument) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{422, R"({"title": "Invalid", "detail": "two fields are wrong",
        "errors": [{"pointer": "/scans/3/ranges", "detail": "empty"}]})"};
  });
  const auto body = client_of(server).send({"POST", "/v1/maps/a/scans", "{}"});
  ASSERT_FALSE(body.ok());
  EXPECT_EQ(body.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(body.error().message, "422 two fields are wrong; /scans/3/ranges: empty");
  EXPECT_EQ(body.error().field, "POST /v1/maps/a/scans");
}

TEST(HttpClient, SaysOnceWhatIsWrongWithOneField) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{422, R"({"title": "Invalid", "detail": "no free cell",
        "errors": [{"pointer": "/image", "detail": "no free cell"}]})"};
  });
  EXPECT_EQ(client_of(server).send({"PUT", "/v1/maps/a/grid"}).error().message,
            "422 no free cell (/image)");
}

TEST(HttpClient, GivesEachStatusItsCode) {
  const std::vector<std::pair<int, ErrorCode>> codes = {
      {400, ErrorCode::kMalformed}, {404, ErrorCode::kNotFound},    {409, ErrorCode::kConflict},
      {413, ErrorCode::kTooLarge},  {507, ErrorCode::kStorageFull}, {500, ErrorCode::kInternal}};
  for (const auto& [status, code] : codes) {
    testing::FakeServer server([status = status](const testing::FakeRequest&) {
      return testing::FakeAnswer{status, ""};
    });
    EXPECT_EQ(client_of(server).send({"GET", "/"}).error().code, code) << status;
  }
}

TEST(HttpClient, AsksAgainWhenTheServerIsBusy) {
  int calls = 0;
  testing::FakeServer server([&calls](const testing::FakeRequest&) {
    if (++calls < 3) return testing::FakeAnswer{calls == 1 ? 503 : 429, "", "0"};
    return testing::FakeAnswer{200, "{}"};
  });
  EXPECT_TRUE(client_of(server).send({"GET", "/"}).ok());
  EXPECT_EQ(server.requests().size(), 3U);
}

TEST(HttpClient, GivesUpOnAServerThatStaysBusy) {
  testing::FakeServer server([](const testing::FakeRequest&) {
    return testing::FakeAnswer{503, "", "0"};
  });
  const auto body = client_of(server).send({"GET", "/"});
  ASSERT_FALSE(body.ok());
  EXPECT_EQ(body.error().code, ErrorCode::kUnavailable);
}

TEST(HttpClient, SaysThatNobodyAnswers) {
  std::string url;
  {
    const testing::FakeServer gone([](const testing::FakeRequest&) {
      return testing::FakeAnswer{200, ""};
    });
    url = gone.url();
  }
  Result<HttpClient> client = HttpClient::create({url, ""});
  ASSERT_TRUE(client.ok());
  const auto body = client->send({"GET", "/"});
  ASSERT_FALSE(body.ok());
  EXPECT_EQ(body.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(body.error().field, url);
  EXPECT_THAT(body.error().message, HasSubstr("is the server running there?"));
}

TEST(HttpClient, RefusesWhatIsNoUrl) {
  for (const char* url : {"", "localhost:8080", "ftp://host", "http://", "http:///path"}) {
    EXPECT_FALSE(HttpClient::create({url, ""}).ok()) << url;
  }
}

}  // namespace
}  // namespace cornerfix::client
