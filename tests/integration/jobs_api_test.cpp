// Long work as jobs, against the real server.
#include <gmock/gmock.h>

#include <csignal>

#include <cornerfix/map_image.hpp>

#include "integration/form_data.hpp"
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
using testing::kForm;
using testing::part;
using testing::Reply;
using ::testing::StartsWith;

const testing::HeaderMap kAsync = {{"Prefer", "respond-async"}};

OccupancyGrid room_grid() {
  return testing::drawn_grid(testing::figure7_room(), {5.0, 5.0}, {-1.0, -1.0, 0.0}, {12.0, 12.0},
                             0.05);
}

/// The same room, in a larger yard.
OccupancyGrid other_room_grid() {
  return testing::drawn_grid(testing::figure7_room(), {5.0, 5.0}, {-2.0, -2.0, 0.0}, {14.0, 14.0},
                             0.05);
}

/// With an image that is none where `image` is given.
std::string form_of(const OccupancyGrid& grid, const std::string& image = {}) {
  const auto png = encode_grid_png(grid);
  const std::string own(reinterpret_cast<const char*>(png.data()), png.size());
  return part("yaml", encode_grid_yaml(grid, "room.png")) +
         part("image", image.empty() ? own : image) + "--xyz--\r\n";
}

/// An occupancy map of the room that the robots of room_drive.hpp are in, with `image` or its own.
std::string room_form(const std::string& image = {}) { return form_of(room_grid(), image); }

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

/// All scans of a run, without poses.
Json unposed_run(const testing::RobotDrive& drive) {
  return {{"lidar", testing::lidar_json()},
          {"scans", testing::session_batch(drive, 0, drive.scans.size())["scans"]}};
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

TEST_F(JobsApiTest, MapsAWholeRunInTheBackground) {
  const testing::RobotDrive drive = testing::robot_drive(150);
  ASSERT_EQ(client_.put("/v1/maps/office", Json::object()).status, 201);
  const Json run = unposed_run(drive);
  EXPECT_EQ(client_.post("/v1/maps/office/scans", run).status, 413);  // As a batch.
  const Reply accepted =
      client_.send("POST", "/v1/maps/office/scans", run.dump(), "application/json", kAsync);
  ASSERT_EQ(accepted.status, 202) << accepted.body;
  EXPECT_EQ(accepted.json()["kind"], "mapping");
  const std::string path = accepted.header("location");
  const Json job = finished_job(client_, path);
  ASSERT_EQ(job["status"], "succeeded") << job;
  EXPECT_EQ(job["stage"], "storing");
  const Json result = client_.get(path + "/result").json();
  EXPECT_EQ(result["accepted"], 150);
  EXPECT_EQ(result["features"], client_.get("/v1/maps/office/features").json()["features"].size());
  EXPECT_EQ(result["revision"], client_.get("/v1/maps/office").json()["revision"]);
}

TEST_F(JobsApiTest, RefusesARunAtOnceThatIsWrong) {
  client_.put("/v1/maps/office", Json::object());
  Json run = unposed_run(testing::robot_drive(3));
  run["scans"][1]["stamp"] = run["scans"][0]["stamp"];
  const auto post = [&](const std::string& map) {
    return client_.send("POST", "/v1/maps/" + map + "/scans", run.dump(), "application/json",
                        kAsync);
  };
  EXPECT_EQ(post("office").json()["errors"][0]["pointer"], "/scans/1/stamp");
  EXPECT_EQ(post("nowhere").status, 404);
  EXPECT_THAT(client_.get("/v1/jobs").json()["jobs"], IsEmpty());
}

TEST_F(JobsApiTest, RestoresAnArchiveInTheBackground) {
  testing::make_room_map(client_, "room");
  const std::string archive = client_.get("/v1/maps/room/archive").body;
  const auto restore = [&](const std::string& map) {
    const Reply accepted = client_.send("POST", "/v1/maps/" + map + "/archive", archive,
                                        "application/vnd.sqlite3", kAsync);
    EXPECT_EQ(accepted.status, 202) << accepted.body;
    return finished_job(client_, accepted.header("location"));
  };
  const Json job = restore("copy");
  ASSERT_EQ(job["status"], "succeeded") << job;
  EXPECT_EQ(job["kind"], "restore");
  EXPECT_EQ(client_.get(job["result"].get<std::string>()).json(),
            client_.get("/v1/maps/copy").json());
  EXPECT_EQ(client_.get("/v1/maps/copy").json()["digest"],
            client_.get("/v1/maps/room").json()["digest"]);
  EXPECT_EQ(restore("room")["problem"]["status"], 409);
}

TEST_F(JobsApiTest, AnswersAsWithoutAJobWhenItIsFinishedWhileTheClientWaits) {
  const testing::HeaderMap waiting = {{"Prefer", "respond-async, wait=60"}};
  const Reply made = put_grid(client_, "plan", waiting);
  EXPECT_EQ(made.status, 201) << made.body;
  EXPECT_EQ(made.header("location"), "/v1/maps/plan");
  EXPECT_EQ(made.json(), put_grid(client_, "other", {}).json());
  EXPECT_EQ(put_grid(client_, "plan", waiting).status, 200);
  const Reply wrong = put_grid(client_, "bad", waiting, room_form("GIF89a"));
  EXPECT_EQ(wrong.status, 400);
  EXPECT_EQ(wrong.header("content-type"), "application/problem+json");
  EXPECT_EQ(wrong.json()["errors"][0]["pointer"], "/image");
}

TEST_F(JobsApiTest, NamesTheMapOfAnArchiveThatTheClientWaitsFor) {
  client_.put("/v1/maps/empty", {{"description", "ground floor"}});
  const std::string archive = client_.get("/v1/maps/empty/archive").body;
  const Reply made =
      client_.send("POST", "/v1/maps/copy/archive", archive, "application/vnd.sqlite3",
                   {{"Prefer", "respond-async, wait=60"}});
  ASSERT_EQ(made.status, 201) << made.body;
  EXPECT_EQ(made.header("location"), "/v1/maps/copy");
  EXPECT_NE(made.header("etag"), "");
  EXPECT_EQ(made.header("etag"), client_.get("/v1/maps/copy").header("etag"));
}

TEST_F(JobsApiTest, ShowsJobsInTheMetrics) {
  put_grid(client_, "plan", {{"Prefer", "respond-async, wait=60"}});
  const std::string metrics = client_.get("/metrics").body;
  EXPECT_THAT(metrics, HasSubstr("cornerfix_jobs{kind=\"import\",status=\"succeeded\"} 1"));
  EXPECT_THAT(metrics, HasSubstr("cornerfix_job_duration_seconds_count{kind=\"import\",status="
                                 "\"succeeded\"} 1"));
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

TEST(JobsApi, DoesNotAddARunToAnotherMapOfTheSameName) {
  const testing::TemporaryDirectory directory;
  leave_job_behind(directory / "test.db", "office");
  const testing::TestServer server(directory / "test.db");
  HttpClient client(server.port());
  ASSERT_EQ(client.put("/v1/maps/office", Json::object()).status, 201);
  const Json run = unposed_run(testing::robot_drive(20));
  const Reply accepted =
      client.send("POST", "/v1/maps/office/scans", run.dump(), "application/json", kAsync);
  ASSERT_EQ(accepted.status, 202) << accepted.body;
  ASSERT_EQ(client.remove("/v1/maps/office").status, 204);
  ASSERT_EQ(client.put("/v1/maps/office", Json::object()).status, 201);
  {
    storage::JobStore jobs(
        storage::Database::open((directory / "test.db").string(), storage::Synchronous::kFull)
            .value());
    const storage::JobOutcome failed{.status = storage::JobStatus::kFailed};
    ASSERT_TRUE(jobs.finish(jobs.find("left")->number, "dead", failed, "t2").value());
  }
  const Json job = finished_job(client, accepted.header("location"));
  EXPECT_EQ(job["status"], "failed") << job;
  EXPECT_EQ(job["problem"]["status"], 409);
  EXPECT_EQ(client.get("/v1/maps/office").json()["keyframes"], 0);
}

/// A job that a server did, up to the answer, before it died; `form` is that of an import.
void leave_import_behind(const std::filesystem::path& database, std::uint64_t map_revision) {
  const OccupancyGrid grid = room_grid();
  const std::string yaml = encode_grid_yaml(grid, "room.png");
  const auto image = encode_grid_png(grid);
  storage::JobStore jobs(
      storage::Database::open(database.string(), storage::Synchronous::kFull).value());
  const storage::BlobView text(reinterpret_cast<const std::uint8_t*>(yaml.data()), yaml.size());
  const storage::BlobView pixels(reinterpret_cast<const std::uint8_t*>(image.data()), image.size());
  ASSERT_TRUE(jobs.insert({.id = "left",
                           .kind = "import",
                           .map = "plan",
                           .created = "t0",
                           .input = {{"yaml", text}, {"image", pixels}},
                           .known_map = storage::JobMap{map_revision}},
                          {}));
  ASSERT_TRUE(jobs.claim("dead", {}, "t1").value());
  ASSERT_TRUE(jobs.release(jobs.find("left")->number, "dead", true));
}

TEST(JobsApi, ARepeatedJobLeavesANewerMapAsItIs) {
  const testing::TemporaryDirectory directory;
  Json newer;
  {
    const testing::TestServer server(directory / "test.db");
    HttpClient client(server.port());
    ASSERT_EQ(put_grid(client, "plan", {}).status, 201);
    newer =
        client.put("/v1/maps/plan", {{"parameters", {{"grid", {{"resolution_m", 0.1}}}}}}).json();
    const Reply replaced = put_grid(client, "plan", {}, form_of(other_room_grid()));
    ASSERT_EQ(replaced.status, 200) << replaced.body;
    newer = client.get("/v1/maps/plan").json();
  }
  leave_import_behind(directory / "test.db", 0);
  const testing::TestServer server(directory / "test.db");
  HttpClient client(server.port());
  const Json job = finished_job(client, "/v1/jobs/left");
  EXPECT_EQ(job["status"], "failed") << job;
  EXPECT_EQ(job["problem"]["status"], 409);
  EXPECT_THAT(job["problem"]["detail"].get<std::string>(), HasSubstr("expected no map"));
  EXPECT_EQ(client.get("/v1/maps/plan").json(), newer);
}

TEST(JobsApi, ARepeatedJobThatWasDoneSucceeds) {
  const testing::TemporaryDirectory directory;
  Json made;
  {
    const testing::TestServer server(directory / "test.db");
    HttpClient client(server.port());
    ASSERT_EQ(put_grid(client, "plan", {}).status, 201);
    made = client.get("/v1/maps/plan").json();
  }
  leave_import_behind(directory / "test.db", 0);
  const testing::TestServer server(directory / "test.db");
  HttpClient client(server.port());
  const Json job = finished_job(client, "/v1/jobs/left");
  EXPECT_EQ(job["status"], "succeeded") << job;
  EXPECT_EQ(client.get("/v1/maps/plan").json(), made);
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
