// `cornerfix serve` as a program: killed, restarted, doubled, stopped.
#include <gmock/gmock.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using testing::HttpClient;
using ::testing::IsEmpty;
using testing::Json;
using ::testing::MatchesRegex;
using testing::Reply;
using testing::ServerProcess;
using ::testing::StartsWith;

class ProcessTest : public ::testing::Test {
 protected:
  std::vector<std::string> arguments() const {
    return {"--db", (directory_ / "test.db").string(), "--port", "0"};
  }
  Reply post(HttpClient& client, const std::string& id, std::uint64_t sequence) {
    return client.post("/v1/sessions/" + id + "/scans", testing::session_batch(drive_, sequence));
  }
  std::string config_file(const std::string& text) {
    std::ofstream(directory_ / "config.json") << text;
    return (directory_ / "config.json").string();
  }

  testing::TemporaryDirectory directory_;
  testing::RobotDrive drive_ = testing::robot_drive();
};

TEST_F(ProcessTest, SaysOneLineWhenItIsReadyAndEndsWithZeroOnSigterm) {
  ServerProcess server(arguments());
  EXPECT_THAT(server.first_line(), MatchesRegex("listening on http://127\\.0\\.0\\.1:[0-9]+"));
  EXPECT_EQ(HttpClient(server.port()).get("/readyz").status, 200);
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
  EXPECT_THAT(server.rest_of_output(), IsEmpty());
}

TEST_F(ProcessTest, EndsWithZeroOnSigint) {
  ServerProcess server(arguments());
  server.signal(SIGINT);
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(ProcessTest, AnswersWhatIsInWorkBeforeItEnds) {
  ServerProcess server(arguments());
  HttpClient client(server.port());
  testing::make_room_map(client, "office");
  const std::string id = testing::open_session(client, "cart-7", "office");
  const std::string body = testing::session_batch(drive_, 0).dump();
  testing::RawConnection slow(server.port());
  slow.send("POST /v1/sessions/" + id + "/scans HTTP/1.1\r\nHost: localhost\r\n" +
            "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
            "\r\nExpect: 100-continue\r\n\r\n");
  ASSERT_THAT(slow.read_until("\r\n\r\n"), StartsWith("HTTP/1.1 100"));  // now it is in work
  slow.send(body.substr(0, 1000));
  server.signal(SIGTERM);
  slow.send(body.substr(1000));
  EXPECT_THAT(slow.read_to_end(), StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(ProcessTest, GoesOnAfterKill9BetweenTwoBatches) {
  std::string id;
  std::string last_answer;
  Json map_before;
  {
    ServerProcess server(arguments());
    HttpClient client(server.port());
    testing::make_room_map(client, "office");
    map_before = client.get("/v1/maps/office").json();
    id = testing::open_session(client, "cart-7", "office");
    for (std::uint64_t i = 0; i < 5; ++i) last_answer = post(client, id, i).body;
    server.signal(SIGKILL);
    EXPECT_EQ(server.wait(), -SIGKILL);
  }
  ServerProcess server(arguments());
  HttpClient client(server.port());
  EXPECT_EQ(client.get("/v1/maps/office").json(), map_before);
  EXPECT_EQ(post(client, id, 4).body, last_answer);
  const Reply ahead = post(client, id, 7);
  ASSERT_EQ(ahead.status, 409);
  Json answer;
  for (std::uint64_t i = ahead.json()["expected"]; i < 10; ++i) {
    const Reply reply = post(client, id, i);
    ASSERT_EQ(reply.status, 200) << reply.body;
    answer = reply.json();
  }
  EXPECT_EQ(answer["status"], "localized");
}

TEST_F(ProcessTest, LosesNoAcknowledgedMappingBatchToKill9) {
  const auto mapping = testing::mapping_drive();
  Json acknowledged;
  {
    ServerProcess server(arguments());
    HttpClient client(server.port());
    client.put("/v1/maps/office", {{"lidar", testing::lidar_json()}});
    acknowledged = client.post("/v1/maps/office/scans", testing::map_batch(mapping, 0, 24)).json();
    server.signal(SIGKILL);
    server.wait();
  }
  ServerProcess server(arguments());
  HttpClient client(server.port());
  const Json entry = client.get("/v1/maps/office").json();
  EXPECT_EQ(entry["revision"], acknowledged["revision"]);
  EXPECT_EQ(entry["keyframes"], acknowledged["keyframes"]);
  const Json again =
      client.post("/v1/maps/office/scans", testing::map_batch(mapping, 0, 48)).json();
  EXPECT_EQ(again["duplicates"], 24);
}

TEST_F(ProcessTest, EndsAnUpdateAfterKill9AsIfThereHadBeenNone) {
  const auto later = testing::mapping_drive(1e6, testing::refurnished_room());
  const auto update = [&](HttpClient& client, const std::string& name, std::size_t begin) {
    EXPECT_EQ(client
                  .post("/v1/maps/" + name + "/scans",
                        testing::map_batch(later, begin, later.size() - begin))
                  .status,
              200);
  };
  {
    ServerProcess server(arguments());
    HttpClient client(server.port());
    testing::make_room_map(client, "office");
    testing::make_room_map(client, "undisturbed");
    client.post("/v1/maps/office/scans", testing::map_batch(later, 0, 20));
    server.signal(SIGKILL);
    server.wait();
  }
  ServerProcess server(arguments());
  HttpClient client(server.port());
  update(client, "office", 10);
  update(client, "undisturbed", 0);
  EXPECT_EQ(client.get("/v1/maps/office").json()["digest"],
            client.get("/v1/maps/undisturbed").json()["digest"]);
  EXPECT_EQ(client.get("/v1/maps/office/features").json()["features"],
            client.get("/v1/maps/undisturbed/features").json()["features"]);
  EXPECT_EQ(client.get("/v1/maps/office/grid.png").body,
            client.get("/v1/maps/undisturbed/grid.png").body);
}

TEST_F(ProcessTest, SharesAFileWithAnotherServer) {
  ServerProcess one(arguments());
  ServerProcess two(arguments());
  HttpClient first(one.port());
  HttpClient second(two.port());
  testing::make_room_map(first, "office");
  EXPECT_EQ(second.get("/v1/maps/office").json(), first.get("/v1/maps/office").json());
  const std::string id = testing::open_session(second, "cart-7", "office");
  for (std::uint64_t i = 0; i < 10; ++i) {
    const Reply reply = post(i % 2 == 0 ? first : second, id, i);
    ASSERT_EQ(reply.status, 200) << reply.body;
  }
  EXPECT_EQ(first.get("/v1/sessions/" + id).json()["status"], "localized");
  EXPECT_EQ(first.remove("/v1/maps/office").status, 204);
  EXPECT_EQ(second.get("/v1/maps/office").status, 404);
}

TEST_F(ProcessTest, NeverSharesAPort) {
  ServerProcess server(arguments());
  auto same = arguments();
  same.back() = std::to_string(server.port());
  same[1] = (directory_ / "other.db").string();
  ServerProcess second(same);
  EXPECT_THAT(second.first_line(), IsEmpty());
  EXPECT_EQ(second.wait(), 1);
  EXPECT_FALSE(std::filesystem::exists(same[1])) << "nothing is left behind";
}

TEST_F(ProcessTest, RefusesWrongUse) {
  const std::string db = (directory_ / "test.db").string();
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"--db", db, "--listen", "0.0.0.0", "--port", "0"},
      {"--db", db, "--config", config_file(R"({"prot": 1})")},
      {"--db", db, "--no-such-flag"},
  };
  for (const auto& flags : wrong) {
    ServerProcess server(flags);
    EXPECT_EQ(server.wait(), 2);
    EXPECT_THAT(server.first_line(), IsEmpty());
  }
}

TEST_F(ProcessTest, RefusesAFileThatIsNotItsOwn) {
  std::ofstream(directory_ / "test.db") << "This is not a database, but it is long enough to see.";
  ServerProcess server(arguments());
  EXPECT_EQ(server.wait(), 1);
  std::ifstream file(directory_ / "test.db");
  std::string word;
  file >> word;
  EXPECT_EQ(word, "This");
}

TEST_F(ProcessTest, ReadsItsConfigurationFile) {
  auto with_config = arguments();
  with_config.push_back("--config");
  with_config.push_back(config_file(
      R"({"tokens": [{"token": "0123456789abcdef", "role": "admin", "name": "a"}], "max_scans": 2})"));
  ServerProcess server(with_config);
  EXPECT_EQ(HttpClient(server.port()).get("/v1/maps").status, 401);
}

TEST_F(ProcessTest, ReloadsTokensOnSighup) {
  const auto with_token = [&](const std::string& token) {
    return config_file(R"({"tokens": [{"token": ")" + token +
                       R"(", "role": "admin", "name": "a"}]})");
  };
  auto with_config = arguments();
  with_config.insert(with_config.end(), {"--config", with_token("old-token-0123456789")});
  ServerProcess server(with_config);
  const auto status_with = [&](const std::string& token) {
    HttpClient client(server.port());
    client.set_header("Authorization", "Bearer " + token);
    return client.get("/v1/maps").status;
  };
  EXPECT_EQ(status_with("old-token-0123456789"), 200);
  with_token("new-token-0123456789");
  server.signal(SIGHUP);
  while (status_with("new-token-0123456789") != 200) {
  }
  EXPECT_EQ(status_with("old-token-0123456789"), 401);
  config_file("this is no configuration");
  server.signal(SIGHUP);
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(ProcessTest, IgnoresSighupWithoutAConfigurationFile) {
  ServerProcess server(arguments());
  server.signal(SIGHUP);
  EXPECT_EQ(HttpClient(server.port()).get("/healthz").status, 200);
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST_F(ProcessTest, EndsInSpiteOfAClientThatNeverEndsItsRequest) {
  auto with_config = arguments();
  with_config.insert(with_config.end(), {"--config", config_file(R"({"drain_timeout_s": 0})")});
  ServerProcess server(with_config);
  testing::RawConnection slow(server.port());
  slow.send(
      "PUT /v1/maps/office HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Content-Length: 2000000\r\nExpect: 100-continue\r\n\r\n");
  ASSERT_THAT(slow.read_until("\r\n\r\n"), StartsWith("HTTP/1.1 100"));  // now it is in work
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

}  // namespace
}  // namespace cornerfix
