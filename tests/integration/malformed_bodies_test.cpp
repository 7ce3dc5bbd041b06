// A request that gets an error changes nothing: a table of bodies, each with what it must get.
#include <gmock/gmock.h>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using testing::Json;
using testing::Reply;

struct WrongBody {
  const char* name;
  const char* method;
  const char* path;  ///< "{id}" is the session's.
  std::string body;
  int status;
};

void PrintTo(const WrongBody& wrong, std::ostream* out) { *out << wrong.name; }

std::string valid_scan(const std::string& ranges = "[1, 2, 3]", const std::string& more = "") {
  return R"({"stamp": 900, "ranges": )" + ranges + more + "}";
}
std::string session_body(const std::string& scans, const std::string& sequence = "1") {
  return R"({"sequence": )" + sequence + R"(, "scans": )" + scans + "}";
}
std::string map_body(const std::string& scans) {
  return R"({"lidar": {"angle_min": 0, "angle_increment": 0.1, "range_min": 0, "range_max": 30}, )"
         R"("scans": )" +
         scans + "}";
}

const std::vector<WrongBody>& wrong_bodies() {
  static const char* const kScans = "/v1/sessions/{id}/scans";
  static const char* const kMapScans = "/v1/maps/office/scans";
  static const std::string kPose = R"(, "pose": {"x": 0, "y": 0, "yaw": 0})";
  static const std::vector<WrongBody> table = {
      {"Empty", "POST", kScans, "", 400},
      {"NotJson", "POST", kScans, "hello", 400},
      {"Truncated", "POST", kScans, R"({"sequence": 1, "scans": [)", 400},
      {"Trailing", "POST", kScans, session_body("[" + valid_scan() + "]") + "x", 400},
      {"AnArray", "POST", kScans, "[]", 422},
      {"BadUtf8", "POST", kScans, "{\"sequence\": \"\xff\"}", 400},
      {"Deep", "POST", kScans, std::string(100'000, '['), 400},
      {"NoSequence", "POST", kScans, R"({"scans": []})", 422},
      {"NegativeSequence", "POST", kScans, session_body("[" + valid_scan() + "]", "-1"), 422},
      {"FractionalSequence", "POST", kScans, session_body("[" + valid_scan() + "]", "1.5"), 422},
      {"TextSequence", "POST", kScans, session_body("[" + valid_scan() + "]", "\"1\""), 422},
      {"NoScans", "POST", kScans, R"({"sequence": 1})", 422},
      {"EmptyScans", "POST", kScans, session_body("[]"), 422},
      {"ScansObject", "POST", kScans, session_body("{}"), 422},
      {"NullScan", "POST", kScans, session_body("[null]"), 422},
      {"NoStamp", "POST", kScans, session_body(R"([{"ranges": [1]}])"), 422},
      {"NoRanges", "POST", kScans, session_body(R"([{"stamp": 1}])"), 422},
      {"TextRange", "POST", kScans, session_body("[" + valid_scan(R"(["1"])") + "]"), 422},
      {"UnknownMember", "POST", kScans,
       session_body("[" + valid_scan("[1, 2, 3]", R"(, "mount": {})") + "]"), 422},
      {"OdomWithoutYaw", "POST", kScans,
       session_body("[" + valid_scan("[1]", R"(, "odom": {"x": 0, "y": 0})") + "]"), 422},
      {"MapScanWithoutPose", "POST", kMapScans, map_body("[" + valid_scan() + "]"), 409},
      {"MapScansMixed", "POST", kMapScans,
       map_body("[" + valid_scan() + ", " + valid_scan("[1]", kPose) + "]"), 422},
      {"MapScanTwiceGoodOnceBad", "POST", kMapScans,
       map_body("[" + valid_scan("[1, 2, 3]", kPose) + ", " + valid_scan("[]", kPose) + "]"), 422},
      {"MapScansNotJson", "POST", kMapScans, "{", 400},
      {"LidarInsideOut", "POST", kMapScans,
       R"({"lidar": {"angle_min": 0, "angle_increment": 0.1, "range_min": 5, "range_max": 1}, "scans": [)" +
           valid_scan("[1]", kPose) + "]}",
       422},
      {"TrajectoryEmpty", "PUT", "/v1/maps/office/trajectory", R"({"poses": []})", 422},
      {"TrajectoryGap", "PUT", "/v1/maps/office/trajectory",
       R"({"poses": [{"stamp": 100, "x": 0, "y": 0, "yaw": 0}]})", 422},
      {"TrajectoryText", "PUT", "/v1/maps/office/trajectory", R"({"poses": "all"})", 422},
      {"MapDescriptionNumber", "PUT", "/v1/maps/office", R"({"description": 1})", 422},
      {"MapUnknownParameter", "PUT", "/v1/maps/office", R"({"parameters": {"colour": 1}})", 422},
      {"MapParameterOutside", "PUT", "/v1/maps/office",
       R"({"parameters": {"min_feature_count": 0}})", 422},
      {"MapNewNotJson", "PUT", "/v1/maps/new", "{", 400},
      {"SessionWithoutRobot", "POST", "/v1/sessions", R"({"map": "office"})", 422},
      {"SessionBadRobot", "POST", "/v1/sessions", R"({"robot": "a b", "map": "office"})", 422},
      {"SessionWithoutMap", "POST", "/v1/sessions", R"({"robot": "a", "map": "nowhere"})", 404},
      {"LocalizeNoScans", "POST", "/v1/maps/office/localize", "{}", 422},
  };
  return table;
}

class MalformedBodiesTest : public ::testing::TestWithParam<WrongBody> {
 protected:
  MalformedBodiesTest() {
    testing::make_room_map(client_, "office");
    id_ = testing::open_session(client_, "cart-7", "office");
    client_.post("/v1/sessions/" + id_ + "/scans", testing::session_batch(drive_, 0));
  }
  /// All there is to see.
  Json everything() {
    return {client_.get("/v1/maps").json(), client_.get("/v1/maps/office/features").json(),
            client_.get("/v1/sessions").json()};
  }

  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  testing::HttpClient client_{server_.port()};
  testing::RobotDrive drive_ = testing::robot_drive();
  std::string id_;
};

TEST_P(MalformedBodiesTest, GetsItsStatusAndChangesNothing) {
  const WrongBody& wrong = GetParam();
  const Json before = everything();
  std::string path = wrong.path;
  if (const auto at = path.find("{id}"); at != std::string::npos) path.replace(at, 4, id_);
  const Reply reply = client_.send(wrong.method, path, wrong.body, "application/json");
  EXPECT_EQ(reply.status, wrong.status) << reply.body;
  EXPECT_EQ(reply.header("content-type"), "application/problem+json");
  if (wrong.status == 422) {
    EXPECT_FALSE(reply.json()["errors"].empty()) << reply.body;
  }
  EXPECT_EQ(everything(), before);
  EXPECT_EQ(
      client_.post("/v1/sessions/" + id_ + "/scans", testing::session_batch(drive_, 1)).status,
      200);
}

INSTANTIATE_TEST_SUITE_P(Table, MalformedBodiesTest, ::testing::ValuesIn(wrong_bodies()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cornerfix
