#include "server/job_service.hpp"

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "unit/server/service_fixture.hpp"

namespace cornerfix::server {
namespace {

using storage::JobRecord;
using storage::JobStatus;
using storage::JobStore;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr std::chrono::milliseconds kLongLease{3'600'000};

/// Looks until `is_so`, for a minute at most.
template <typename Condition>
[[nodiscard]] bool comes_true(Condition is_so) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!is_so()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

Result<std::string> give_up() { return Error{ErrorCode::kUnavailable, "given up", ""}; }

/// Works until it has to give up.
Result<std::string> work_on(const JobTask& task) {
  while (task.progress("walls", 0.25)) std::this_thread::yield();
  return give_up();
}

Result<std::string> echo(const JobTask& task) {
  if (!task.progress("reading", 0.5)) return give_up();
  const auto text = task.input.find("text");
  return text == task.input.end() ? std::string("{}")
                                  : std::string(text->second.begin(), text->second.end());
}

class JobServiceTest : public ServiceTest {
 protected:
  std::shared_ptr<JobService> serve(const JobRunner& runner,
                                    std::chrono::milliseconds lease = kLongLease,
                                    const NowText& expired_before = {},
                                    storage::JobLimits limits = {}) {
    return std::make_shared<JobService>(
        process_.stores, JobRunners{{"work", runner}},
        JobServiceSettings{.now = [] { return kNow; },
                           .expired_before = expired_before,
                           .limits = limits,
                           .lease = lease,
                           .heartbeat = std::chrono::milliseconds(5),
                           .patience = std::chrono::milliseconds(0)});
  }
  static std::string submit(JobService& service, const std::string& map = "office",
                            const std::string& text = "{}") {
    const storage::BlobView bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    const auto job = service.submit("work", map, {{"text", bytes}});
    EXPECT_TRUE(job && job->has_value());
    return job && *job ? (*job)->id : "";
  }
  JobRecord find(const std::string& id) {
    return process_.stores->with_jobs([&](JobStore& jobs) { return jobs.find(id); }).value();
  }
  bool becomes(const std::string& id, JobStatus status) {
    return comes_true([&] { return find(id).status == status; });
  }
  /// A job that a server claimed which then died, `attempts` times.
  std::string leave_behind(const std::string& id, std::size_t attempts = 1) {
    const auto left = process_.stores->with_jobs([&](JobStore& jobs) -> Result<void> {
      const auto job = jobs.insert({.id = id, .kind = "work", .map = "lab", .created = kNow}, {});
      if (!job) return job.error();
      for (std::size_t i = 0; i < attempts; ++i) {
        const auto open = jobs.open_jobs();
        if (!open) return open.error();
        if (const auto claimed = jobs.claim("dead", open->running, kNow); !claimed)
          return claimed.error();
      }
      return {};
    });
    EXPECT_TRUE(left);
    return id;
  }

  Process process_{file()};
};

TEST_F(JobServiceTest, DoesAJobAndKeepsItsAnswer) {
  const auto service = serve(echo);
  const std::string id = submit(*service, "office", R"({"a":1})");
  ASSERT_TRUE(becomes(id, JobStatus::kSucceeded));
  EXPECT_EQ(service->answer(id).value(), R"({"a":1})");
  const JobRecord job = service->find(id).value();
  EXPECT_EQ(job.map, "office");
  EXPECT_EQ(job.progress, 1.0);
  EXPECT_EQ(job.started, kNow);
  EXPECT_EQ(job.finished, kNow);
}

TEST_F(JobServiceTest, KeepsTheProblemOfAJobThatFailsAndGoesOn) {
  const auto service = serve([](const JobTask& task) -> Result<std::string> {
    if (task.map == "broken") throw std::runtime_error("secret");
    if (task.map == "wrong") return Error{ErrorCode::kInvalidArgument, "no walls", "/image"};
    return std::string("{}");
  });
  const std::string wrong = submit(*service, "wrong");
  const std::string broken = submit(*service, "broken");
  const std::string good = submit(*service, "good");
  ASSERT_TRUE(becomes(good, JobStatus::kSucceeded));
  const auto problem = nlohmann::json::parse(find(wrong).problem);
  EXPECT_EQ(find(wrong).status, JobStatus::kFailed);
  EXPECT_EQ(problem["code"], "invalid_argument");
  EXPECT_EQ(problem["errors"][0]["pointer"], "/image");
  EXPECT_EQ(find(broken).status, JobStatus::kFailed);
  EXPECT_THAT(find(broken).problem, HasSubstr("internal"));
  EXPECT_THAT(find(broken).problem, Not(HasSubstr("secret")));
}

TEST_F(JobServiceTest, FailsAJobOfAnUnknownKind) {
  const auto service = serve(echo);
  const auto job = service->submit("other", "office", {});
  ASSERT_TRUE(job && job->has_value());
  EXPECT_TRUE(becomes((*job)->id, JobStatus::kFailed));
}

TEST_F(JobServiceTest, DoesOneJobAfterTheOther) {
  std::atomic<int> at_once{0};
  std::atomic<bool> overlapped{false};
  const auto service = serve([&](const JobTask& task) {
    if (++at_once > 1) overlapped = true;
    auto answer = echo(task);
    --at_once;
    return answer;
  });
  std::vector<std::string> ids;
  for (const char* map : {"a", "b", "c", "a"}) ids.push_back(submit(*service, map));
  for (const std::string& id : ids) EXPECT_TRUE(becomes(id, JobStatus::kSucceeded));
  EXPECT_FALSE(overlapped);
}

TEST_F(JobServiceTest, ShowsHowFarAJobIsAndCancelsIt) {
  const auto service = serve(work_on);
  const std::string id = submit(*service);
  ASSERT_TRUE(comes_true([&] { return find(id).progress > 0.0; }));
  EXPECT_EQ(find(id).stage, "walls");
  EXPECT_EQ(find(id).progress, 0.25);
  EXPECT_EQ(find(id).status, JobStatus::kRunning);
  ASSERT_TRUE(service->cancel(id));
  EXPECT_TRUE(becomes(id, JobStatus::kCancelled));
}

TEST_F(JobServiceTest, RefusesMoreJobsThanMayWait) {
  const auto service = serve(work_on, kLongLease, {}, {.jobs = 1});
  const std::string id = submit(*service);
  const auto refused = service->submit("work", "office", {});
  ASSERT_TRUE(refused);
  EXPECT_FALSE(refused->has_value());
}

TEST_F(JobServiceTest, PutsTheJobInWorkBackWhenItEndsAndTheNextServerDoesIt) {
  std::string id;
  {
    const auto service = serve(work_on);
    id = submit(*service, "office", R"({"a":1})");
    ASSERT_TRUE(becomes(id, JobStatus::kRunning));
  }
  EXPECT_EQ(find(id).status, JobStatus::kQueued);
  EXPECT_EQ(find(id).attempts, 0U);
  const auto next = serve(echo);
  ASSERT_TRUE(becomes(id, JobStatus::kSucceeded));
  EXPECT_EQ(next->answer(id).value(), R"({"a":1})");
}

TEST_F(JobServiceTest, PutsAJobBackWhoseThreadDoesNotEnd) {
  std::atomic<bool> may_end{false};
  std::string id;
  {
    const auto service = serve([&](const JobTask&) -> Result<std::string> {
      while (!may_end) std::this_thread::yield();
      return std::string("{}");
    });
    id = submit(*service);
    EXPECT_TRUE(becomes(id, JobStatus::kRunning));
    service->close();
    EXPECT_TRUE(becomes(id, JobStatus::kQueued));
    EXPECT_EQ(find(id).attempts, 0U);
    may_end = true;
  }
  EXPECT_EQ(find(id).status, JobStatus::kQueued);
  const auto next = serve(echo);
  EXPECT_TRUE(becomes(id, JobStatus::kSucceeded));
}

TEST_F(JobServiceTest, TakesTheJobOfADeadServerOverWhenItsLeaseHasRunOut) {
  const std::string id = leave_behind("left");
  {
    const auto patient = serve(echo);
    ASSERT_TRUE(becomes(submit(*patient), JobStatus::kSucceeded));
    EXPECT_EQ(find(id).holder, "dead");
  }
  const auto service = serve(echo, std::chrono::milliseconds(0));
  EXPECT_TRUE(becomes(id, JobStatus::kSucceeded));
}

TEST_F(JobServiceTest, GivesUpAJobThatAnotherServerHasTakenOver) {
  const auto service = serve(work_on);
  const std::string id = submit(*service);
  ASSERT_TRUE(becomes(id, JobStatus::kRunning));
  ASSERT_TRUE(comes_true([&] {
    return process_.stores
        ->with_jobs([](JobStore& jobs) {
          return jobs.claim("other", jobs.open_jobs().value().running, kNow);
        })
        .value()
        .has_value();
  }));
  // The service is free again when it has given the job up.
  const std::string next = submit(*service, "lab");
  ASSERT_TRUE(becomes(next, JobStatus::kRunning));
  EXPECT_EQ(find(id).holder, "other");
  EXPECT_EQ(find(id).status, JobStatus::kRunning);
}

TEST_F(JobServiceTest, FailsAJobThatServersHaveBegunTooOften) {
  const std::string id = leave_behind("left", JobService::kMaxAttempts);
  const auto service = serve(echo, std::chrono::milliseconds(0));
  ASSERT_TRUE(becomes(id, JobStatus::kFailed));
  EXPECT_THAT(find(id).problem, HasSubstr("3 times"));
}

TEST_F(JobServiceTest, HandsOutTheMapsRevisionAtAcceptanceOrAfterTheJobsBefore) {
  ASSERT_TRUE(process_.maps->put("office", {}));
  std::vector<std::uint64_t> revisions;
  std::atomic<bool> are_both_there{false};
  const auto change = [&](const JobTask& task) -> Result<std::string> {
    while (!are_both_there) std::this_thread::yield();
    revisions.push_back(task.known_map.revision);
    api::Lidar lidar;
    lidar.angle_min = 0.1 * static_cast<double>(revisions.size());
    if (!process_.maps->put("office", {{}, lidar, {}})) return Error{};
    return std::string("{}");
  };
  std::string last;
  {
    const auto service = serve(change);
    ASSERT_TRUE(service->submit("work", "office", {}, storage::JobMap{1}));
    last = service->submit("work", "office", {}, storage::JobMap{1}).value()->id;
    are_both_there = true;
    ASSERT_TRUE(becomes(last, JobStatus::kSucceeded));
  }
  EXPECT_EQ(revisions, (std::vector<std::uint64_t>{1, 2}));
}

TEST_F(JobServiceTest, FailsAJobWhoseMapWasDeletedAlsoWhenAnotherHasItsName) {
  std::atomic<bool> may_begin{false};
  const auto service = serve([&](const JobTask& task) -> Result<std::string> {
    while (task.map == "lab" && !may_begin) std::this_thread::yield();
    return std::string("{}");
  });
  ASSERT_TRUE(becomes(submit(*service, "lab"), JobStatus::kRunning));
  std::vector<std::string> ids;
  for (const char* map : {"gone", "replaced"}) {
    ASSERT_TRUE(process_.maps->put(map, {}));
    const storage::MapInfo info = process_.maps->find(map).value();
    for (int i = 0; i < 2; ++i) {  // The second one takes over what the first one leaves.
      const auto job = service->submit("work", map, {}, storage::JobMap{info.revision, info.id});
      ids.push_back(job.value().value().id);
    }
    ASSERT_TRUE(process_.maps->remove(map));
  }
  ASSERT_TRUE(process_.maps->put("replaced", {}));
  may_begin = true;
  for (const std::string& id : ids) {
    ASSERT_TRUE(becomes(id, JobStatus::kFailed)) << find(id).map;
    EXPECT_EQ(nlohmann::json::parse(find(id).problem)["status"], 409) << find(id).map;
    EXPECT_THAT(find(id).problem, HasSubstr("was deleted"));
  }
}

TEST_F(JobServiceTest, KeepsToTheMapThatAnEarlierJobMade) {
  std::atomic<bool> may_begin{false};
  std::vector<std::int64_t> ids;
  const auto service = serve([&](const JobTask& task) -> Result<std::string> {
    while (!may_begin) std::this_thread::yield();
    ids.push_back(task.known_map.id);
    if (!process_.maps->put(task.map, {})) return Error{};
    return std::string("{}");
  });
  std::string last;
  for (int i = 0; i < 2; ++i)
    last = service->submit("work", "office", {}, storage::JobMap{}).value()->id;
  may_begin = true;
  ASSERT_TRUE(becomes(last, JobStatus::kSucceeded));
  EXPECT_EQ(ids, (std::vector<std::int64_t>{0, process_.maps->find("office")->id}));
}

TEST_F(JobServiceTest, WaitsForAJobUntilItIsFinished) {
  const auto service = serve(echo);
  const auto job = service->wait_for(submit(*service), std::chrono::seconds(60));
  ASSERT_TRUE(job);
  EXPECT_EQ(job->status, JobStatus::kSucceeded);
  EXPECT_FALSE(service->wait_for("unknown", std::chrono::seconds(60)));
}

TEST_F(JobServiceTest, WaitsNoLongerThanAskedOrUntilItEnds) {
  const auto service = serve(work_on);
  const std::string id = submit(*service);
  EXPECT_FALSE(is_finished(service->wait_for(id, std::chrono::seconds(0))->status));
  std::thread closing([&] {
    ASSERT_TRUE(becomes(id, JobStatus::kRunning));
    service->close();
  });
  EXPECT_FALSE(is_finished(service->wait_for(id, std::chrono::seconds(3600))->status));
  closing.join();
}

TEST_F(JobServiceTest, SaysHowLongTheWorkOfAJobTook) {
  std::vector<std::string> ends;
  {
    JobService service(
        process_.stores, {{"work", echo}},
        {.now = [] { return kNow; },
         .on_end =
             [&](std::string_view kind, JobStatus status, double seconds) {
               EXPECT_GE(seconds, 0.0);
               ends.push_back(std::string(kind) + " " + std::string(to_string(status)));
             },
         .heartbeat = std::chrono::milliseconds(5)});
    ASSERT_TRUE(becomes(submit(service), JobStatus::kSucceeded));
  }
  EXPECT_EQ(ends, std::vector<std::string>{"work succeeded"});
}

TEST_F(JobServiceTest, TriesAgainWhatMayWorkLater) {
  std::atomic<int> calls{0};
  const auto service = serve([&](const JobTask&) -> Result<std::string> {
    if (++calls == 1) return Error{ErrorCode::kUnavailable, "the database is busy", ""};
    return std::string("{}");
  });
  EXPECT_TRUE(becomes(submit(*service), JobStatus::kSucceeded));
  EXPECT_EQ(calls, 2);
}

TEST_F(JobServiceTest, EndsAJobThatWasCancelledBeforeItsServerDied) {
  const std::string id = leave_behind("left");
  ASSERT_TRUE(process_.stores->with_jobs([&](JobStore& jobs) { return jobs.cancel(id, kNow); }));
  const auto service = serve(echo, std::chrono::milliseconds(0));
  EXPECT_TRUE(becomes(id, JobStatus::kCancelled));
}

TEST_F(JobServiceTest, RemovesFinishedJobsWithTime) {
  ASSERT_TRUE(process_.stores->with_jobs([&](JobStore& jobs) -> Result<void> {
    const auto job = jobs.insert({.id = "old", .kind = "work", .map = "lab", .created = kNow}, {});
    if (!job) return job.error();
    if (const auto ended = jobs.cancel("old", kNow); !ended) return ended.error();
    return {};
  }));
  const auto service = serve(echo, kLongLease, [] { return "2999-01-01T00:00:00Z"; });
  EXPECT_TRUE(comes_true([&] { return service->list({}).value().empty(); }));
}

}  // namespace
}  // namespace cornerfix::server
