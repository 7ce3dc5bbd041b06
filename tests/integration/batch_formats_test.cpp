// Batches of a session in each of their formats, against the real server.
#include <gmock/gmock.h>

#include <limits>
#include <string>

#include "integration/test_server.hpp"
#include "support/binary_text.hpp"

namespace cornerfix {
namespace {

using testing::Json;
using testing::Reply;

class BatchFormatsTest : public ::testing::Test {
 protected:
  BatchFormatsTest() { testing::make_room_map(client_, "office"); }

  Reply post(const std::string& id, const Json& batch) {
    return client_.post("/v1/sessions/" + id + "/scans", batch);
  }

  /// session_batch() as application/octet-stream.
  [[nodiscard]] std::string binary_batch(std::uint64_t sequence) const {
    const std::size_t first = 3 * sequence;
    const auto beams = static_cast<std::uint32_t>(drive_.scans.at(first).scan.ranges.size());
    std::string body =
        api::binary_header({.flags = 1, .sequence = sequence, .scans = 3, .beams = beams});
    for (std::size_t i = first; i < first + 3; ++i) {
      const RobotScan& robot_scan = drive_.scans.at(i);
      const Pose2& odometry = *robot_scan.T_odom_base_link;
      body += api::binary_text(robot_scan.scan.stamp, odometry.x, odometry.y, odometry.yaw);
      for (std::size_t beam = 0; beam < beams; ++beam) {
        body += api::binary_text(robot_scan.scan.has_return(beam)
                                     ? robot_scan.scan.ranges[beam]
                                     : std::numeric_limits<float>::quiet_NaN());
      }
    }
    return body;
  }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  testing::HttpClient client_{server_.port()};
  testing::RobotDrive drive_ = testing::robot_drive();
};

TEST_F(BatchFormatsTest, TakeAndGiveCborAndMessagePack) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  const auto cbor = Json::to_cbor(testing::session_batch(drive_, 0));
  const Reply first =
      client_.send("POST", "/v1/sessions/" + id + "/scans", std::string(cbor.begin(), cbor.end()),
                   "application/cbor", {{"Accept", "application/cbor"}});
  ASSERT_EQ(first.status, 200) << first.body;
  EXPECT_EQ(first.header("content-type"), "application/cbor");
  EXPECT_EQ(Json::from_cbor(first.body)["sequence"], 0);
  const auto packed = Json::to_msgpack(testing::session_batch(drive_, 1));
  const Reply second = client_.send("POST", "/v1/sessions/" + id + "/scans",
                                    std::string(packed.begin(), packed.end()),
                                    "application/msgpack", {{"Accept", "application/msgpack"}});
  ASSERT_EQ(second.status, 200) << second.body;
  EXPECT_EQ(Json::from_msgpack(second.body)["sequence"], 1);
}

TEST_F(BatchFormatsTest, TakeABinaryBatchAsTheSameInJson) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  const auto post_bytes = [&](const std::string& path, const std::string& bytes) {
    return client_.send("POST", path, bytes, "application/octet-stream");
  };
  const std::string scans = "/v1/sessions/" + id + "/scans";
  const Reply binary = post_bytes(scans, binary_batch(0));
  ASSERT_EQ(binary.status, 200) << binary.body;
  EXPECT_EQ(binary.json()["sequence"], 0);
  const Reply json = post(id, testing::session_batch(drive_, 0));
  EXPECT_EQ(json.body, binary.body) << "The second is the same batch.";
  EXPECT_EQ(post_bytes(scans, binary_batch(1).substr(1)).status, 400);
  EXPECT_EQ(post_bytes("/v1/sessions", binary_batch(1)).status, 415);
}

TEST_F(BatchFormatsTest, TakeALaserScanOfRosbridge) {
  const std::string id = testing::open_session(client_, "cart-7", "office");
  Json scan = testing::session_batch(drive_, 0)["scans"][0];
  Json message = testing::lidar_json();
  message["header"] = {{"stamp", {{"secs", 12}, {"nsecs", 500'000'000}}}, {"frame_id", "laser"}};
  message["ranges"] = scan["ranges"];
  message["intensities"] = Json::array();
  const Reply reply = post(id, Json{{"sequence", 0}, {"scans", {message}}});
  EXPECT_EQ(reply.status, 200) << reply.body;
}

}  // namespace
}  // namespace cornerfix
