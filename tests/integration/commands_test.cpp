// `cornerfix token` and `cornerfix load` as programs, against the real server.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "integration/test_server.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using testing::HttpClient;
using testing::Json;
using ::testing::MatchesRegex;
using ::testing::Not;
using testing::Program;

class CommandsTest : public ::testing::Test {
 protected:
  struct Outcome {
    int exit_code = 0;
    std::string out;
  };
  static Outcome run(const std::vector<std::string>& arguments) {
    Program program(CORNERFIX_PROGRAM, arguments);
    const int exit_code = program.wait();
    return {exit_code, program.rest_of_output()};
  }
  Outcome token(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "token");
    arguments.insert(arguments.end(), {"--db", database_});
    return run(arguments);
  }
  /// Prints one line: the token.
  std::string new_token(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "create");
    std::string out = token(arguments).out;
    EXPECT_THAT(out, MatchesRegex("cfx_[0-9a-f]+\n"));
    out.pop_back();
    return out;
  }
  HttpClient holder_of(const std::string& token) const {
    HttpClient client(server_.port());
    client.set_header("Authorization", "Bearer " + token);
    return client;
  }

  testing::TemporaryDirectory directory_;
  std::string database_ = (directory_ / "test.db").string();
  testing::TestServer server_{database_};
};

TEST_F(CommandsTest, ATokenIsGoodUntilItIsRevoked) {
  const std::string desk = new_token({"--role", "viewer", "--name", "desk"});
  HttpClient viewer = holder_of(desk);
  EXPECT_EQ(viewer.get("/v1/maps").status, 200);
  EXPECT_EQ(viewer.put("/v1/maps/office", Json::object()).status, 403);
  EXPECT_EQ(HttpClient(server_.port()).get("/v1/maps").status, 401);
  EXPECT_EQ(token({"revoke", "1"}).exit_code, 0);
  EXPECT_EQ(viewer.get("/v1/maps").status, 401);
  EXPECT_EQ(token({"revoke", "1"}).exit_code, 1);
}

TEST_F(CommandsTest, ARobotsTokenIsForItsNameAndMaps) {
  HttpClient admin = holder_of(new_token({"--role", "admin", "--name", "boss"}));
  ASSERT_EQ(admin.put("/v1/maps/office", Json::object()).status, 201);
  ASSERT_EQ(admin.put("/v1/maps/store", Json::object()).status, 201);
  HttpClient robot = holder_of(
      new_token({"--role", "robot", "--name", "cart-7", "--map", "office", "--days", "1"}));
  const auto open = [&](const char* name, const char* map) {
    return robot.post("/v1/sessions", testing::session_request(name, map)).status;
  };
  EXPECT_EQ(open("cart-7", "office"), 201);
  EXPECT_EQ(open("cart-7", "store"), 403);
  EXPECT_EQ(open("cart-8", "office"), 403);
}

TEST_F(CommandsTest, TokensAreListedWithoutTheirSecret) {
  const std::string secret = new_token({"--role", "robot", "--name", "cart-7", "--map", "office"});
  const Outcome listed = token({"list"});
  EXPECT_EQ(listed.exit_code, 0);
  EXPECT_THAT(listed.out, HasSubstr("cart-7"));
  EXPECT_THAT(listed.out, HasSubstr("office"));
  EXPECT_THAT(listed.out, Not(HasSubstr(secret)));
}

TEST_F(CommandsTest, TokensOfNoDatabaseAreNotListedNorRevoked) {
  const std::string none = (directory_ / "none.db").string();
  EXPECT_EQ(run({"token", "list", "--db", none}).exit_code, 1);
  EXPECT_EQ(run({"token", "revoke", "1", "--db", none}).exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(none));
}

TEST_F(CommandsTest, OutputThatCannotBeWrittenIsAFailure) {
  const std::string command =
      std::string(CORNERFIX_PROGRAM) + " token list --db " + database_ + " > ";
  EXPECT_EQ(std::system((command + "/dev/null").c_str()), 0);               // NOLINT
  EXPECT_EQ(WEXITSTATUS(std::system((command + "/dev/full").c_str())), 1);  // NOLINT
}

TEST_F(CommandsTest, AWrongRoleOrNameIsWrongUse) {
  EXPECT_EQ(token({"create", "--role", "king", "--name", "a"}).exit_code, 2);
  EXPECT_EQ(token({"create", "--role", "admin", "--name", "../a"}).exit_code, 2);
}

/// The scans of a robot as a log.
std::string log_text() {
  const testing::RobotDrive drive = testing::robot_drive();
  const Json lidar = testing::lidar_json();
  Json header = lidar;
  header["name"] = "walk";
  header["beams"] = drive.scans.front().scan.ranges.size();
  header.erase("mount");
  std::string text = header.dump() + "\n";
  const Json scans = testing::session_batch(drive, 0, drive.scans.size())["scans"];
  for (const Json& scan : scans) {
    const Json& odom = scan["odom"];
    const Json pose = {odom["x"], odom["y"], odom["yaw"]};
    text += Json{{"t", scan["stamp"]}, {"ranges", scan["ranges"]}, {"odom", pose}, {"pose", pose}}
                .dump() +
            "\n";
  }
  return text;
}

TEST_F(CommandsTest, AFleetPostsEachBatchAndLeavesNoSession) {
  HttpClient client(server_.port());
  testing::make_room_map(client, "office");
  const std::string log = (directory_ / "walk.jsonl").string();
  std::ofstream(log) << log_text();
  const Outcome outcome =
      run({"load", log, "--map", "office", "--robots", "3", "--rate", "10", "--batch", "2",
           "--ramp", "0", "--seconds", "0.5", "--searching", "0.4", "--json", "--server",
           "http://127.0.0.1:" + std::to_string(server_.port())});
  EXPECT_THAT(outcome.exit_code, ::testing::AnyOf(0, 1));  // 1: a busy machine answered late.
  const Json report = Json::parse(outcome.out);
  for (const char* robots : {"tracking", "searching"}) {
    const Json& tally = report[robots];
    EXPECT_GE(tally["offered"], 4) << robots;
    EXPECT_EQ(tally["served"], tally["offered"]) << robots;
    EXPECT_EQ(tally["failed"], 0) << robots;
    EXPECT_GT(tally["latency_ms"]["p50"], 0.0) << robots;
  }
  EXPECT_EQ(client.get("/v1/sessions").json()["sessions"], Json::array());
}

TEST_F(CommandsTest, AFleetNeedsAServer) {
  const std::string log = (directory_ / "walk.jsonl").string();
  std::ofstream(log) << log_text();
  EXPECT_EQ(run({"load", log, "--server", "http://127.0.0.1:1"}).exit_code, 1);
}

}  // namespace
}  // namespace cornerfix
