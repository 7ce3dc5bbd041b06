// As many robots at once as the server has threads for.
#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using testing::HttpClient;
using testing::Json;

constexpr int kRobots = 200;
constexpr std::uint64_t kBatches = 2;

TEST(Fleet, IsServedOnKeepAliveConnectionsWithoutAMiss) {
  const testing::TemporaryDirectory directory;
  testing::TestServer server(directory / "test.db");
  {
    HttpClient client(server.port());
    testing::make_room_map(client, "office");
  }
  const auto drive = testing::robot_drive(kBatches);
  std::atomic<int> served = 0;
  std::vector<std::thread> robots;
  for (int robot = 0; robot < kRobots; ++robot) {
    robots.emplace_back([&, robot] {
      HttpClient client(server.port());
      const std::string id =
          testing::open_session(client, "cart-" + std::to_string(robot), "office");
      for (std::uint64_t i = 0; i < kBatches; ++i) {
        const auto reply =
            client.post("/v1/sessions/" + id + "/scans", testing::session_batch(drive, i, 1));
        if (reply.status == 200) ++served;
      }
    });
  }
  for (std::thread& robot : robots) robot.join();
  EXPECT_EQ(served, kRobots * static_cast<int>(kBatches));
}

}  // namespace
}  // namespace cornerfix
