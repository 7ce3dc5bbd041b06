// Server-Sent Events of a session.
#include <gmock/gmock.h>

#include <future>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using testing::HttpClient;
using testing::Json;
using ::testing::StartsWith;

server::ServerConfig with_one_event_client() {
  server::ServerConfig config;
  config.max_event_clients = 1;
  return config;
}

/// Reads a stream on a thread of its own until it holds `count` events.
class EventReader {
 public:
  EventReader(int port, const std::string& session, std::size_t count)
      : text_(std::async(std::launch::async, [this, port, session, count] {
          HttpClient client(port);
          std::string text;
          std::size_t events = 0;
          const auto reply =
              client.stream("/v1/sessions/" + session + "/events", [&](std::string_view piece) {
                text += piece;
                events = count_of("\n\n", text);
                if (events >= 1 && !told_) {
                  told_ = true;
                  first_.set_value();
                }
                return events < count;
              });
          if (!told_) first_.set_value();
          return text;
        })) {}

  void wait_for_first() { first_.get_future().wait(); }
  std::string text() { return text_.get(); }

  static std::size_t count_of(std::string_view what, std::string_view text) {
    std::size_t count = 0;
    for (auto at = text.find(what); at != text.npos; at = text.find(what, at + 1)) ++count;
    return count;
  }

 private:
  bool told_ = false;
  std::promise<void> first_;
  std::future<std::string> text_;
};

class EventsTest : public ::testing::Test {
 protected:
  EventsTest() {
    testing::make_room_map(client_, "office");
    id_ = testing::open_session(client_, "cart-7", "office");
  }
  testing::Reply post(std::uint64_t sequence) {
    return client_.post("/v1/sessions/" + id_ + "/scans", testing::session_batch(drive_, sequence));
  }
  static Json data_of(const std::string& event) {
    const auto begin = event.find("data: ") + 6;
    return Json::parse(event.substr(begin, event.find('\n', begin) - begin));
  }

  testing::TemporaryDirectory directory_;
  std::unique_ptr<testing::TestServer> server_ =
      std::make_unique<testing::TestServer>(directory_ / "test.db", with_one_event_client());
  HttpClient client_{server_->port()};
  testing::RobotDrive drive_ = testing::robot_drive();
  std::string id_;
};

TEST_F(EventsTest, TellsTheLastAnswerAtOnceAndThenEachNewOne) {
  const Json first = post(0).json();
  EventReader reader(server_->port(), id_, 3);
  reader.wait_for_first();
  post(1);
  const Json third = post(2).json();
  const std::string text = reader.text();
  EXPECT_THAT(text, StartsWith("event: answer\nid: 0\ndata: "));
  EXPECT_THAT(text, HasSubstr("event: answer\nid: 1\n"));
  Json data = data_of(text.substr(text.find("id: 2")));
  EXPECT_EQ(data["scan_points"].size(), 360U);
  data.erase("scan_points");
  data.erase("feature_points");
  EXPECT_EQ(data, third);
}

TEST_F(EventsTest, EndsWithTheSession) {
  post(0);
  EventReader reader(server_->port(), id_, 100);
  reader.wait_for_first();
  client_.remove("/v1/sessions/" + id_);
  EXPECT_EQ(EventReader::count_of("event: answer", reader.text()), 1U);
}

TEST_F(EventsTest, EndsWhenTheServerDrains) {
  post(0);
  EventReader reader(server_->port(), id_, 100);
  reader.wait_for_first();
  server_->drain();
  EXPECT_EQ(EventReader::count_of("event: answer", reader.text()), 1U);
}

TEST_F(EventsTest, AreForSoManyClientsOnly) {
  post(0);
  EventReader reader(server_->port(), id_, 100);
  reader.wait_for_first();
  const auto refused = client_.get("/v1/sessions/" + id_ + "/events");
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.header("retry-after"), "1");
  client_.remove("/v1/sessions/" + id_);
}

TEST_F(EventsTest, AreNotThereForAnUnknownSession) {
  EXPECT_EQ(client_.get("/v1/sessions/none/events").status, 404);
}

}  // namespace
}  // namespace cornerfix
