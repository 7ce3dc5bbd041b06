#include "storage/job_store.hpp"

#include <gmock/gmock.h>

#include "storage/job_tables.hpp"
#include "unit/storage/engines.hpp"

namespace cornerfix::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class JobStoreTest : public EngineTest {
 protected:
  /// A queued import into `map`.
  std::int64_t add(const std::string& id, const std::string& map = "office") {
    const auto job = store_.insert({.id = id, .kind = "import", .map = map, .created = "t0"}, {});
    EXPECT_TRUE(job && job->has_value());
    return (*job)->number;
  }
  /// The number of a new job that changes `map`.
  std::int64_t add_change(const std::string& id, const std::string& map, JobMap known) {
    return store_
        .insert({.id = id, .kind = "import", .map = map, .created = "t0", .known_map = known}, {})
        .value()
        .value()
        .number;
  }
  /// The id of the job that `server` gets, or "".
  std::string claim(const std::string& server, const std::vector<JobLease>& expired = {}) {
    const auto job = store_.claim(server, expired, "t1");
    EXPECT_TRUE(job) << job.error().message;
    return job && *job ? (*job)->id : "";
  }
  JobStatus status(const std::string& id) { return store_.find(id).value().status; }

  std::shared_ptr<Database> database_ = databases_.open("jobs");
  JobStore store_{database_};
};

INSTANTIATE_TEST_SUITE_P(Engines, JobStoreTest, ::testing::ValuesIn(engines()), EngineName());

TEST_P(JobStoreTest, GivesBackAJobAndItsInputAsTheyWere) {
  const Blob yaml = {1, 0, 2};
  const Blob image(100'000, 7);
  const auto inserted = store_.insert({.id = "a",
                                       .kind = "import",
                                       .map = "office",
                                       .created = "t0",
                                       .input = {{"yaml", yaml}, {"image", image}}},
                                      {});
  ASSERT_TRUE(inserted && inserted->has_value());
  const JobRecord job = JobStore(databases_.open("jobs")).find("a").value();
  EXPECT_EQ(job.number, (*inserted)->number);
  EXPECT_EQ(job.kind, "import");
  EXPECT_EQ(job.map, "office");
  EXPECT_EQ(job.created, "t0");
  EXPECT_EQ(job.status, JobStatus::kQueued);
  EXPECT_EQ(job.progress, 0.0);
  EXPECT_EQ(job.started + job.finished + job.stage + job.problem + job.holder, "");
  EXPECT_EQ(store_.input(job.number).value(), (JobInput{{"image", image}, {"yaml", yaml}}));
}

TEST_P(JobStoreTest, KeepsTheMapsRevisionWhereNoEarlierJobMayChangeIt) {
  const auto revision = [&](std::int64_t job) { return map_revision(store_.input(job).value()); };
  EXPECT_EQ(revision(add("report", "lab")), std::nullopt);
  EXPECT_EQ(revision(add_change("a", "office", {7})), 7U);
  const std::int64_t after = add_change("b", "office", {7});
  EXPECT_EQ(revision(after), std::nullopt);
  EXPECT_EQ(revision(add_change("c", "office", {7, 0, true})), 7U);
  EXPECT_EQ(revision(add_change("d", "hall", {0})), 0U);
  ASSERT_TRUE(store_.keep_map(after, 8, 0));
  EXPECT_EQ(revision(after), 8U);
}

TEST_P(JobStoreTest, KeepsTheMapThatAJobIsAbout) {
  const auto map = [&](std::int64_t job) { return map_id(store_.input(job).value()); };
  EXPECT_EQ(map(add("any", "lab")), 0);
  EXPECT_EQ(map(add_change("a", "office", {7, 21})), 21);
  EXPECT_EQ(map(add_change("b", "office", {7, 21})), 21);
  const std::int64_t creation = add_change("c", "hall", {});
  const std::int64_t after = add_change("d", "hall", {});
  EXPECT_EQ(map(creation), 0);
  ASSERT_TRUE(store_.keep_map(after, 1, 22));
  EXPECT_EQ(map(after), 22);
}

TEST_P(JobStoreTest, CountsJobsByKindAndStatus) {
  EXPECT_THAT(store_.counts().value(), IsEmpty());
  for (const char* id : {"a", "b", "c"}) add(id);
  ASSERT_TRUE(store_.cancel("b", "t1"));
  const auto counts = store_.counts().value();
  ASSERT_EQ(counts.size(), 2U);
  EXPECT_EQ(counts[0].kind, "import");
  EXPECT_EQ(counts[0].status, JobStatus::kCancelled);
  EXPECT_EQ(counts[0].jobs, 1U);
  EXPECT_EQ(counts[1].status, JobStatus::kQueued);
  EXPECT_EQ(counts[1].jobs, 2U);
}

TEST_P(JobStoreTest, DoesNotKnowOtherJobs) {
  EXPECT_EQ(store_.find("a").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_.cancel("a", "t1").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_.answer("a").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_.renew(7, "server", "", 0.5).value(), LeaseState::kLost);
  EXPECT_FALSE(store_.finish(7, "server", {}, "t1").value());
}

TEST_P(JobStoreTest, ListsJobsInPages) {
  for (const char* id : {"a", "b", "c"}) add(id);
  const auto ids_of = [](const std::vector<JobRecord>& jobs) {
    std::vector<std::string> ids;
    for (const JobRecord& job : jobs) ids.push_back(job.id);
    return ids;
  };
  const std::vector<JobRecord> page = store_.list({.limit = 2}).value();
  EXPECT_THAT(ids_of(page), ElementsAre("a", "b"));
  EXPECT_THAT(ids_of(store_.list({.after = page.back().number}).value()), ElementsAre("c"));
}

TEST_P(JobStoreTest, LimitsWhatIsNotFinishedByNumberAndBytes) {
  const Blob content(60);
  const JobLimits limits{.jobs = 2, .bytes = 100};
  const auto insert = [&](const std::string& id, const std::map<std::string, BlobView>& input) {
    return store_
        .insert({.id = id, .kind = "import", .map = id, .created = "t0", .input = input}, limits)
        .value()
        .has_value();
  };
  EXPECT_TRUE(insert("a", {{"image", content}}));
  EXPECT_FALSE(insert("b", {{"image", content}}));
  EXPECT_TRUE(insert("c", {}));
  EXPECT_FALSE(insert("d", {}));
  ASSERT_TRUE(store_.cancel("a", "t1"));
  EXPECT_TRUE(insert("e", {{"image", content}}));
}

TEST_P(JobStoreTest, GivesTheOldestJobToOneServer) {
  add("a", "office");
  add("b", "lab");
  EXPECT_EQ(claim("one"), "a");
  EXPECT_EQ(claim("two"), "b");
  EXPECT_EQ(claim("two"), "");
  const JobRecord job = store_.find("a").value();
  EXPECT_EQ(job.status, JobStatus::kRunning);
  EXPECT_EQ(job.holder, "one");
  EXPECT_EQ(job.started, "t1");
  EXPECT_EQ(job.attempts, 1U);
}

TEST_P(JobStoreTest, RunsTheJobsOfAMapOneAfterTheOther) {
  const std::int64_t first = add("a", "office");
  add("b", "office");
  EXPECT_EQ(claim("one"), "a");
  EXPECT_EQ(claim("two"), "");
  ASSERT_TRUE(store_.finish(first, "one", {}, "t2").value());
  EXPECT_EQ(claim("two"), "b");
}

TEST_P(JobStoreTest, DoesNotWaitForAServerThatIsClaiming) {
  if (GetParam() == Engine::kSqlite) return;  // Has one writer at a time.
  add("a", "office");
  add("b", "lab");
  const std::shared_ptr<Database> other = databases_.open("jobs");
  const auto transaction = other->begin(Access::kWrite);
  ASSERT_EQ(other->jobs().find_claimable({})->id, "a");
  EXPECT_EQ(claim("one"), "b");
}

TEST_P(JobStoreTest, LetsAnotherServerTakeOverOnlyWhatHasNotBeenRenewed) {
  const std::int64_t job = add("a");
  EXPECT_EQ(claim("one"), "a");
  const std::vector<JobLease> seen = store_.open_jobs().value().running;
  ASSERT_EQ(seen.size(), 1U);
  ASSERT_EQ(store_.renew(job, "one", "features", 0.25).value(), LeaseState::kHeld);
  EXPECT_EQ(claim("two", seen), "");
  const std::vector<JobLease> seen_later = store_.open_jobs().value().running;
  EXPECT_NE(seen_later, seen);
  EXPECT_EQ(claim("two", seen_later), "a");
  EXPECT_EQ(store_.find("a")->attempts, 2U);
  EXPECT_EQ(store_.find("a")->progress, 0.0);

  EXPECT_EQ(store_.renew(job, "one", "features", 0.5).value(), LeaseState::kLost);
  ASSERT_TRUE(store_.release(job, "one", true));
  EXPECT_FALSE(store_.finish(job, "one", {.answer = "{}"}, "t3").value());
  EXPECT_EQ(store_.find("a")->holder, "two");
  EXPECT_TRUE(store_.finish(job, "two", {.answer = "{}"}, "t3").value());
}

TEST_P(JobStoreTest, ShowsHowFarAJobIs) {
  const std::int64_t job = add("a");
  EXPECT_EQ(claim("one"), "a");
  ASSERT_EQ(store_.renew(job, "one", "features", 0.25).value(), LeaseState::kHeld);
  EXPECT_EQ(store_.find("a")->stage, "features");
  EXPECT_EQ(store_.find("a")->progress, 0.25);
}

TEST_P(JobStoreTest, KeepsTheAnswerOfAJobThatSucceededAndDropsItsInput) {
  const Blob content(10);
  const auto inserted = store_.insert(
      {.id = "a", .kind = "import", .map = "m", .created = "t0", .input = {{"image", content}}},
      {});
  const std::int64_t job = inserted.value()->number;
  EXPECT_EQ(store_.answer("a").error().code, ErrorCode::kConflict);
  EXPECT_EQ(claim("one"), "a");
  ASSERT_TRUE(store_.finish(job, "one", {.answer = "{\"revision\":1}"}, "t2").value());
  EXPECT_EQ(store_.answer("a").value(), "{\"revision\":1}");
  EXPECT_EQ(store_.find("a")->finished, "t2");
  EXPECT_EQ(store_.find("a")->progress, 1.0);
  EXPECT_THAT(store_.input(job).value(), IsEmpty());
}

TEST_P(JobStoreTest, KeepsTheProblemOfAJobThatFailed) {
  const std::int64_t job = add("a");
  EXPECT_EQ(claim("one"), "a");
  ASSERT_TRUE(
      store_.finish(job, "one", {.status = JobStatus::kFailed, .problem = "{}"}, "t2").value());
  EXPECT_EQ(status("a"), JobStatus::kFailed);
  EXPECT_EQ(store_.find("a")->problem, "{}");
  EXPECT_THAT(store_.answer("a").error().message, HasSubstr("failed"));
}

TEST_P(JobStoreTest, CancelsAQueuedJobAtOnceAndAsksTheHolderOfARunningOne) {
  add("queued", "lab");
  EXPECT_EQ(store_.cancel("queued", "t1")->status, JobStatus::kCancelled);
  EXPECT_EQ(store_.find("queued")->finished, "t1");
  const std::int64_t job = add("running");
  EXPECT_EQ(claim("one"), "running");
  const JobRecord asked = store_.cancel("running", "t1").value();
  EXPECT_EQ(asked.status, JobStatus::kRunning);
  EXPECT_TRUE(asked.is_cancelling);
  EXPECT_EQ(store_.renew(job, "one", "", 0.1).value(), LeaseState::kCancelled);
  ASSERT_TRUE(store_.finish(job, "one", {.status = JobStatus::kCancelled}, "t2").value());
  EXPECT_EQ(store_.cancel("running", "t3").error().code, ErrorCode::kConflict);
}

TEST_P(JobStoreTest, PutsAJobBackIntoTheQueueWithoutOrWithAnAttempt) {
  const std::int64_t job = add("a");
  EXPECT_EQ(claim("one"), "a");
  ASSERT_TRUE(store_.release(job, "one", false));
  EXPECT_EQ(status("a"), JobStatus::kQueued);
  EXPECT_EQ(store_.find("a")->attempts, 0U);
  EXPECT_EQ(claim("two"), "a");
  ASSERT_TRUE(store_.release(job, "two", true));
  EXPECT_EQ(store_.find("a")->attempts, 1U);
}

TEST_P(JobStoreTest, RemovesFinishedJobsWithTime) {
  add("old");
  ASSERT_TRUE(store_.cancel("old", "2024-05-01T00:00:00Z"));
  add("new");
  ASSERT_TRUE(store_.cancel("new", "2024-05-03T00:00:00Z"));
  add("waiting");
  ASSERT_TRUE(store_.remove_finished_before("2024-05-02T00:00:00Z"));
  EXPECT_EQ(store_.find("old").error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(store_.find("new"));
  EXPECT_TRUE(store_.find("waiting"));
}

TEST_P(JobStoreTest, DoesNotMakeOtherServersReadTheirMapsAnew) {
  if (GetParam() == Engine::kSqlite) return;  // Counts every change.
  const std::shared_ptr<Database> other = databases_.open("jobs");
  const std::int64_t before = other->data_version().value();
  add("a");
  EXPECT_EQ(other->data_version().value(), before);
}

}  // namespace
}  // namespace cornerfix::storage
