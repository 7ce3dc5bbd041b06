// Long work as jobs, against the real server.
#include <gmock/gmock.h>

#include <csignal>

#include <cornerfix/map_image.hpp>

#include "integration/test_server.hpp"
#include "storage/database.hpp"
#include "storage/job_store.hpp"
#include "support/drawn_grid.hpp"

namespace cornerfix {
namespace {

using ::testing::HasSubstr;
using testing::HttpClient;
using ::testing::IsEmpty;
using testing::Json;
using testing::Reply;
using ::testing::StartsWith;

constexpr const char* kForm = "multipart/form-data; boundary=xyz";
const testing::HeaderMap kAsync = {{"Prefer", "respond-async"}};

std::string part(const std::string& name, const std::string& content) {
  return "--xyz\r\nContent-Disposition: form-data; name=\"" + name + "\"; filename=\"" + name +
         "\"\r\n\r\n" + content + "\r\n";
}

/// An occupancy map of the room that the robots of room_drive.hpp are in, with `image` or its own.
std::string room_form(const std::string& image = {}) {
  const OccupancyGrid grid = testing::drawn_grid(testing::figure7_room(), {5.0, 5.0},
                                                 {-1.0, -1.0, 0.0}, {12.0, 12.0}, 0.05);
  const auto png = encode_grid_png(grid);
  const std::string own(reinterpret_cast<const char*>(png.data()), png.size());
  return part("yaml", encode_grid_yaml(grid, "room.png")) +
         part("image", image.empty() ? own : image) + "--xyz--\r\n";
}

Reply put_grid(HttpClient& client, const std::string& map, const testing::HeaderMap& headers,
               const std::string& form = room_form()) {
  return client.send("PUT", "/v1/maps/" + map + "/grid", form, kForm, headers);
}

/// The job at `path` when it is finished.
Json finished_job(HttpClient& client, const std::string& path) {
  for (;;) {
    const Reply reply = client.get(path);
    if (reply.status == 429) continue;  // Asked more often than a server allows.
    if (reply.status != 200) return {{"status", reply.body}};
    Json job = reply.json();
    if (job["status"] != "queued" && job["status"] != "running") return job;
  }
}

/// Leaves a job that a server claimed which then died: later jobs of this map wait for it.
void leave_job_behind(const std::filesystem::path& database, const std::string& map) {
  storage::JobStore jobs(
      storage::Database::open(database.string(), storage::Synchronous::kFull).value());
  ASSERT_TRUE(jobs.insert({.id = "left", .kind = "import", .map = map, .created = "t0"}, {}));
  ASSERT_TRUE(jobs.claim("dead", {}, "t1").value());
}

class JobsApiTest : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
  testing::TestServer server_{directory_ / "test.db"};
  HttpClient client_{server_.port()};
};

TEST_F(JobsApiTest, ImportsAnOccupancyMapInTheBackground) {
  const Reply accepted = put_grid(client_, "plan", kAsync);
  ASSERT_EQ(accepted.status, 202) << accepted.body;
  EXPECT_EQ(accepted.header("preference-applied"), "respond-async");
  const std::string path = accepted.header("location");
  EXPECT_THAT(path, StartsWith("/v1/jobs/"));
  EXPECT_EQ(accepted.json()["kind"], "import");
  EXPECT_EQ(accepted.json()["map"], "plan");
  EXPECT_EQ("/v1/jobs/" + accepted.json()["id"].get<std::string>(), path);

  const Json job = finished_job(client_, path);
  ASSERT_EQ(job["status"], "succeeded") << job;
  EXPECT_EQ(job["progress"], 1.0);
  EXPECT_EQ(job["stage"], "storing");
  EXPECT_EQ(job["problem"], nullptr);
  ASSERT_EQ(job["result"], path + "/result");
  const Json result = client_.get(path + "/result").json();
  const Reply at_once = put_grid(client_, "other", {});
  ASSERT_EQ(at_once.status, 201);
  EXPECT_EQ(result, at_once.json());
  EXPECT_EQ(client_.get("/v1/maps/plan").json()["digest"], result["digest"]);
}

TEST_F(JobsApiTest, AnswersAsBeforeWithoutThePreference) {
  EXPECT_EQ(put_grid(client_, "a", {{"Prefer", "wait=10"}}).status, 201);
  EXPECT_EQ(put_grid(client_, "b", {{"Prefer", "wait"}}).status, 201);
  EXPECT_EQ(put_grid(client_, "c", {}).status, 201);
  EXPECT_THAT(client_.get("/v1/jobs").json()["jobs"], IsEmpty());
}

TEST_F(JobsApiTest, ReportsWhatIsWrongWithTheFilesInTheJob) {
  const Reply accepted = put_grid(client_, "plan", kAsync, room_form("GIF89a"));
  ASSERT_EQ(accepted.status, 202);
  const std::string path = accepted.header("location");
  const Json job = finished_job(client_, path);
  ASSERT_EQ(job["status"], "failed") << job;
  EXPECT_EQ(job["problem"]["status"], 400);
  EXPECT_EQ(job["problem"]["errors"][0]["pointer"], "/image");
  EXPECT_EQ(job["result"], nullptr);
  EXPECT_EQ(client_.get(path + "/result").status, 409);
  EXPECT_EQ(client_.get("/v1/maps/plan").status, 404);
  EXPECT_EQ(client_.remove(path).status, 409);
}

TEST_F(JobsApiTest, RefusesAtOnceWhatIsNoFormOrName) {
  EXPECT_EQ(put_grid(client_, "-plan", kAsync).status, 422);
  EXPECT_EQ(put_grid(client_, "plan", kAsync, part("yaml", "a") + "--xyz--\r\n").status, 422);
  EXPECT_THAT(client_.get("/v1/jobs").json()["jobs"], IsEmpty());
}

TEST_F(JobsApiTest, MakesAReportInTheBackground) {
  testing::make_room_map(client_, "room");
  const Reply accepted = client_.get("/v1/maps/room/report", kAsync);
  ASSERT_EQ(accepted.status, 202) << accepted.body;
  const std::string path = accepted.header("location");
  const Json job = finished_job(client_, path);
  ASSERT_EQ(job["status"], "succeeded") << job;
  EXPECT_EQ(job["kind"], "report");
  EXPECT_EQ(client_.get(path + "/result").json(), client_.get("/v1/maps/room/report").json());
  EXPECT_EQ(client_.get("/v1/maps/nowhere/report", kAsync).status, 404);
}

TEST_F(JobsApiTest, ListsJobsInPages) {
  for (const char* map : {"a", "b", "c"}) EXPECT_EQ(put_grid(client_, map, kAsync).status, 202);
  const Json first = client_.get("/v1/jobs?limit=2").json();
  ASSERT_EQ(first["jobs"].size(), 2U);
  EXPECT_EQ(first["jobs"][0]["map"], "a");
  const Json rest =
      client_.get("/v1/jobs?page_token=" + first["next_page_token"].get<std::string>()).json();
  ASSERT_EQ(rest["jobs"].size(), 1U);
  EXPECT_EQ(rest["jobs"][0]["map"], "c");
  EXPECT_EQ(rest["next_page_token"], nullptr);
  EXPECT_EQ(client_.get("/v1/jobs?limit=0").status, 422);
  EXPECT_EQ(client_.get("/v1/jobs?page_token=x").status, 422);
}

TEST_F(JobsApiTest, DoesNotKnowOtherJobs) {
  EXPECT_EQ(client_.get("/v1/jobs/nothing").status, 404);
  EXPECT_EQ(client_.get("/v1/jobs/nothing/result").status, 404);
  EXPECT_EQ(client_.remove("/v1/jobs/nothing").status, 404);
}

TEST(JobsApi, CancelsAJobThatWaits) {
  const testing::TemporaryDirectory directory;
  leave_job_behind(directory / "test.db", "plan");
  const testing::TestServer server(directory / "test.db");
  HttpClient client(server.port());
  const std::string path = put_grid(client, "plan", kAsync).header("location");
  EXPECT_EQ(client.get(path).json()["status"], "queued");
  const Reply cancelled = client.remove(path);
  EXPECT_EQ(cancelled.status, 200) << cancelled.body;
  EXPECT_EQ(cancelled.json()["status"], "cancelled");
  EXPECT_EQ(client.get(path).json()["status"], "cancelled");
  EXPECT_EQ(client.remove(path).status, 409);
}

TEST(JobsApi, LimitsTheJobsThatWaitAndTheirBytes) {
  const testing::TemporaryDirectory directory;
  leave_job_behind(directory / "test.db", "plan");
  const auto expect_refused = [&](const server::ServerConfig& config) {
    const testing::TestServer server(directory / "test.db", config);
    HttpClient client(server.port());
    const Reply refused = put_grid(client, "plan", kAsync);
    EXPECT_EQ(refused.status, 429) << refused.body;
    EXPECT_EQ(refused.json()["code"], "too_many_jobs");
    EXPECT_EQ(refused.header("retry-after"), "60");
  };
  server::ServerConfig config;
  config.max_jobs = 1;
  expect_refused(config);
  config = {};
  config.max_job_bytes = 100;
  expect_refused(config);
}

TEST(JobsApi, ShowsJobsToThoseWhoMayChangeMapsOnly) {
  const testing::TemporaryDirectory directory;
  server::ServerConfig config;
  config.tokens = {{"viewer-token-0123", server::Role::kViewer, "desk"},
                   {"robot7-token-0123", server::Role::kRobot, "cart-7"},
                   {"mapper-token-0123", server::Role::kMapper, "cad"}};
  const testing::TestServer server(directory / "test.db", config);
  HttpClient mapper(server.port());
  mapper.set_header("Authorization", "Bearer mapper-token-0123");
  testing::make_room_map(mapper, "room");
  const std::string path = put_grid(mapper, "plan", kAsync).header("location");
  for (const char* token : {"viewer-token-0123", "robot7-token-0123"}) {
    HttpClient other(server.port());
    other.set_header("Authorization", std::string("Bearer ") + token);
    EXPECT_EQ(other.get("/v1/jobs").status, 403);
    EXPECT_EQ(other.get(path).status, 403);
    EXPECT_EQ(other.get(path + "/result").status, 403);
    EXPECT_EQ(other.remove(path).status, 403);
    // A report makes no job for them: the preference is ignored.
    const Reply report = other.get("/v1/maps/room/report?wait=0", kAsync);
    EXPECT_EQ(report.status, 202);
    EXPECT_EQ(report.header("location"), "");
  }
  EXPECT_EQ(HttpClient(server.port()).get("/v1/jobs").status, 401);
  EXPECT_EQ(mapper.get("/v1/jobs").json()["jobs"].size(), 1U);
  EXPECT_EQ(finished_job(mapper, path)["status"], "succeeded");
}

TEST(JobsApi, AJobSurvivesTheEndOfTheServer) {
  const testing::TemporaryDirectory directory;
  const std::vector<std::string> arguments = {"--db", (directory / "test.db").string(), "--port",
                                              "0"};
  std::vector<std::string> paths;
  {
    testing::ServerProcess server(arguments);
    HttpClient client(server.port());
    for (const char* map : {"a", "b", "c", "d"})
      paths.push_back(put_grid(client, map, kAsync).header("location"));
    server.signal(SIGTERM);
    EXPECT_EQ(server.wait(), 0);
  }
  testing::ServerProcess server(arguments);
  HttpClient client(server.port());
  for (const std::string& path : paths)
    EXPECT_EQ(finished_job(client, path)["status"], "succeeded") << path;
}

}  // namespace
}  // namespace cornerfix
