#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "support/fake_server.hpp"
#include "unit/cli/command_run.hpp"

namespace cornerfix::cli {
namespace {

using ::testing::HasSubstr;

class ReplayCommand : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
};

/// A server that finds the robot at the third batch.
testing::FakeAnswer find_at_third_batch(const testing::FakeRequest& request) {
  if (request.path == "/v1/sessions") return {201, R"({"id": "s-1", "robot": "replay"})"};
  if (request.method == "DELETE") return {204, ""};
  const auto sequence = nlohmann::json::parse(request.body)["sequence"].get<int>();
  if (sequence < 2) {
    return {200, R"({"status": "collecting", "reason": "few_features", "pose": null})"};
  }
  return {200, R"({"status": "localized", "confidence": 0.99, "reason": null,
      "pose": {"map": "attic", "x": 5.1, "y": 0.0, "yaw": 0.0}})"};
}

TEST_F(ReplayCommand, EndsSomeMetresAfterTheFirstLocalizedAnswer) {
  const std::string log = directory_.write("walk.jsonl", walk(40)).string();
  testing::FakeServer server(find_at_third_batch);
  const Outcome outcome = run({"replay", log.c_str(), "--map", "attic", "--batch", "2", "--track",
                               "3", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("collecting  few_features"));
  EXPECT_THAT(outcome.out, HasSubstr("attic: x 5.10 m, y 0.00 m, yaw 0.0 deg (confidence 0.990)"));
  EXPECT_THAT(outcome.out,
              HasSubstr("true: x 5.00 m, y 0.00 m, yaw 0.0 deg; error 0.10 m, 0.0 deg"));
  const auto requests = server.requests();
  // Started, three batches until localized at 5 m, two more to 9 m, ended.
  ASSERT_EQ(requests.size(), 7U);
  EXPECT_EQ(nlohmann::json::parse(requests[0].body)["map"], "attic");
  EXPECT_EQ(requests[5].path, "/v1/sessions/s-1/scans");
  const auto batch = nlohmann::json::parse(requests[5].body);
  EXPECT_EQ(batch["sequence"], 4);
  EXPECT_EQ(batch["scans"][1]["odom"]["x"], 9.0);
  EXPECT_EQ(requests[6].method + " " + requests[6].path, "DELETE /v1/sessions/s-1");
}

TEST_F(ReplayCommand, EndsWithOneWhenTheLogEndsFirst) {
  const std::string log = directory_.write("walk.jsonl", walk(4)).string();
  testing::FakeServer server(find_at_third_batch);
  const Outcome outcome =
      run({"replay", log.c_str(), "--batch", "2", "--server", server.url().c_str()});
  EXPECT_EQ(outcome.exit_code, 1);
}

TEST_F(ReplayCommand, StartsAtTheGivenScanOrTime) {
  const std::string log = directory_.write("walk.jsonl", walk(20)).string();
  const std::vector<std::pair<std::vector<std::string>, double>> first_stamps = {
      {{}, 0.0},
      {{"--from", "7"}, 7.0},
      {{"--from", "2.5s"}, 3.0},
      {{"--split", "0.5"}, 10.0},
      {{"--split", "0.5", "--from", "4"}, 14.0}};
  for (const auto& [options, stamp] : first_stamps) {
    testing::FakeServer server(find_at_third_batch);
    const std::string url = server.url();
    std::vector<std::string> arguments = {"replay", log.c_str(), "--no-odom", "--server",
                                          url.c_str()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    run(arguments);
    const auto scans = nlohmann::json::parse(server.requests()[1].body)["scans"];
    EXPECT_EQ(scans[0]["stamp"], stamp);
    EXPECT_FALSE(scans[0].contains("odom"));
  }
}

}  // namespace
}  // namespace cornerfix::cli
