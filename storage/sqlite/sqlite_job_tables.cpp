#include <algorithm>
#include <limits>
#include <string>

#include "storage/sqlite/sqlite_tables.hpp"
#include "storage/sqlite/statement.hpp"

namespace cornerfix::storage {
namespace {

const std::string kSelectJob =
    "SELECT number, id, kind, map, status, stage, progress, created, started, finished, problem, "
    "cancelling, attempts, holder, heartbeat FROM jobs ";

JobRecord read_job(const Statement& row) {
  return {.number = row.integer(0),
          .id = row.text(1),
          .kind = row.text(2),
          .map = row.text(3),
          .status = job_status_from(row.text(4)),
          .stage = row.text(5),
          .progress = row.real(6),
          .created = row.text(7),
          .started = row.text(8),
          .finished = row.text(9),
          .problem = row.text(10),
          .is_cancelling = row.integer(11) != 0,
          .attempts = row.number(12),
          .holder = row.text(13),
          .heartbeat = row.number(14)};
}

class SqliteJobTables : public JobTables {
 public:
  explicit SqliteJobTables(SqliteDatabase& database) : database_(database) {}

  std::int64_t insert(const NewJob& job) override {
    Statement(database_, "INSERT INTO jobs (id, kind, map, created) VALUES (?, ?, ?, ?)")
        .bind(job.id, job.kind, job.map, job.created)
        .run();
    const std::int64_t number = database_.last_row_id();
    for (const auto& [name, content] : job.input) insert_input(number, name, content);
    return number;
  }

  JobLoad load() override {
    Statement row(database_,
                  "SELECT count(*), coalesce(sum((SELECT sum(length(content)) FROM job_inputs "
                  "WHERE job = number)), 0) FROM jobs WHERE status IN ('queued', 'running')");
    row.step();
    return {.jobs = static_cast<std::size_t>(row.number(0)), .input_bytes = row.number(1)};
  }

  std::vector<JobCount> counts() override {
    Statement row(database_,
                  "SELECT kind, status, count(*) FROM jobs GROUP BY kind, status ORDER BY 1, 2");
    std::vector<JobCount> counts;
    for (row.bind(); row.step();) {
      counts.push_back(
          {row.text(0), job_status_from(row.text(1)), static_cast<std::size_t>(row.number(2))});
    }
    return counts;
  }

  bool has_unfinished(std::string_view map) override {
    Statement row(database_,
                  "SELECT 1 FROM jobs WHERE map = ? AND status IN ('queued', 'running') LIMIT 1");
    return row.bind(map).step();
  }

  std::optional<JobRecord> find(std::string_view id) override {
    static const std::string sql = kSelectJob + "WHERE id = ?";
    Statement row(database_, sql);
    return row.bind(id).step() ? std::optional(read_job(row)) : std::nullopt;
  }

  std::optional<JobRecord> find(std::int64_t number) override {
    static const std::string sql = kSelectJob + "WHERE number = ?";
    Statement row(database_, sql);
    return row.bind(number).step() ? std::optional(read_job(row)) : std::nullopt;
  }

  std::vector<JobRecord> list(const JobPage& page) override {
    static const std::string sql = kSelectJob + "WHERE number > ? ORDER BY number LIMIT ?";
    constexpr std::size_t kMost = std::numeric_limits<std::int64_t>::max();
    Statement row(database_, sql);
    std::vector<JobRecord> jobs;
    for (row.bind(page.after, std::uint64_t{std::min(page.limit, kMost)}); row.step();)
      jobs.push_back(read_job(row));
    return jobs;
  }

  OpenJobs open_jobs() override {
    OpenJobs open;
    Statement row(database_,
                  "SELECT number, status, heartbeat FROM jobs WHERE status IN ('queued', "
                  "'running') ORDER BY number");
    for (row.bind(); row.step();) {
      if (job_status_from(row.text(1)) == JobStatus::kQueued) {
        ++open.queued;
      } else {
        open.running.push_back({row.integer(0), row.number(2)});
      }
    }
    return open;
  }

  std::optional<JobRecord> find_claimable(std::span<const JobLease> expired) override {
    static const std::string sql =
        kSelectJob +
        "WHERE status IN ('queued', 'running') AND NOT EXISTS (SELECT 1 FROM jobs AS earlier WHERE "
        "earlier.map = jobs.map AND earlier.number < jobs.number AND earlier.status IN ('queued', "
        "'running')) ORDER BY number";
    Statement row(database_, sql);
    for (row.bind(); row.step();) {
      JobRecord job = read_job(row);
      const JobLease lease{job.number, job.heartbeat};
      const bool is_free =
          job.status == JobStatus::kQueued || std::ranges::find(expired, lease) != expired.end();
      if (is_free) return job;
    }
    return std::nullopt;
  }

  void update(const JobRecord& job) override {
    Statement(database_,
              "UPDATE jobs SET status = ?, stage = ?, progress = ?, started = ?, finished = ?, "
              "problem = ?, cancelling = ?, attempts = ?, holder = ?, heartbeat = ? "
              "WHERE number = ?")
        .bind(to_string(job.status), job.stage, job.progress, job.started, job.finished,
              job.problem, std::int64_t{job.is_cancelling ? 1 : 0}, job.attempts, job.holder,
              job.heartbeat, job.number)
        .run();
  }

  std::string answer(std::int64_t number) override {
    Statement row(database_, "SELECT answer FROM jobs WHERE number = ?");
    return row.bind(number).step() ? row.text(0) : std::string();
  }

  void put_answer(std::int64_t number, std::string_view answer) override {
    Statement(database_, "UPDATE jobs SET answer = ? WHERE number = ?").bind(answer, number).run();
  }

  JobInput input(std::int64_t number) override {
    Statement row(database_, "SELECT name, content FROM job_inputs WHERE job = ? ORDER BY name");
    JobInput input;
    for (row.bind(number); row.step();) {
      const BlobView content = row.blob(1);
      input[row.text(0)].assign(content.begin(), content.end());
    }
    return input;
  }

  void insert_input(std::int64_t number, std::string_view name, BlobView content) override {
    Statement(database_, "INSERT INTO job_inputs (job, name, content) VALUES (?, ?, ?)")
        .bind(number, name, content)
        .run();
  }

  void remove_input(std::int64_t number) override {
    Statement(database_, "DELETE FROM job_inputs WHERE job = ?").bind(number).run();
  }

  void remove_finished_before(std::string_view time) override {
    Statement(database_, "DELETE FROM jobs WHERE finished <> '' AND finished < ?").bind(time).run();
  }

 private:
  SqliteDatabase& database_;
};

}  // namespace

std::unique_ptr<JobTables> make_job_tables(SqliteDatabase& database) {
  return std::make_unique<SqliteJobTables>(database);
}

}  // namespace cornerfix::storage
