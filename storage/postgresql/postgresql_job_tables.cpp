#include <algorithm>
#include <limits>
#include <string>

#include "storage/postgresql/postgresql_connection.hpp"
#include "storage/postgresql/postgresql_tables.hpp"

namespace cornerfix::storage {
namespace {

const std::string kSelectJobs =
    "SELECT number, id, kind, map, status, stage, progress, created, started, finished, problem, "
    "cancelling, attempts, holder, heartbeat FROM jobs ";

JobRecord read_job_row(const PostgresqlRows& rows, int row) {
  return {.number = rows.integer(row, 0),
          .id = rows.text(row, 1),
          .kind = rows.text(row, 2),
          .map = rows.text(row, 3),
          .status = job_status_from(rows.text(row, 4)),
          .stage = rows.text(row, 5),
          .progress = rows.real(row, 6),
          .created = rows.text(row, 7),
          .started = rows.text(row, 8),
          .finished = rows.text(row, 9),
          .problem = rows.text(row, 10),
          .is_cancelling = rows.boolean(row, 11),
          .attempts = rows.number(row, 12),
          .holder = rows.text(row, 13),
          .heartbeat = rows.number(row, 14)};
}

class PostgresqlJobTables : public JobTables {
 public:
  explicit PostgresqlJobTables(PostgresqlConnection& connection) : connection_(connection) {}

  std::int64_t insert(const NewJob& job) override {
    const std::int64_t number =
        connection_
            .execute(
                "INSERT INTO jobs (id, kind, map, created) VALUES ($1, $2, $3, $4) "
                "RETURNING number",
                job.id, job.kind, job.map, job.created)
            .integer(0, 0);
    for (const auto& [name, content] : job.input) insert_input(number, name, content);
    return number;
  }

  JobLoad load() override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT count(*), coalesce(sum((SELECT sum(octet_length(content)) FROM job_inputs "
        "WHERE job = number)), 0)::bigint FROM jobs WHERE status IN ('queued', 'running')");
    return {.jobs = static_cast<std::size_t>(rows.number(0, 0)), .input_bytes = rows.number(0, 1)};
  }

  std::vector<JobCount> counts() override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT kind, status, count(*) FROM jobs GROUP BY kind, status ORDER BY 1, 2");
    std::vector<JobCount> counts;
    counts.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row) {
      counts.push_back({rows.text(row, 0), job_status_from(rows.text(row, 1)),
                        static_cast<std::size_t>(rows.number(row, 2))});
    }
    return counts;
  }

  bool has_unfinished(std::string_view map) override {
    return !connection_
                .execute(
                    "SELECT 1 FROM jobs WHERE map = $1 AND status IN ('queued', 'running') "
                    "LIMIT 1",
                    map)
                .empty();
  }

  std::optional<JobRecord> find(std::string_view id) override {
    static const std::string sql = kSelectJobs + "WHERE id = $1";
    return first(sql, id);
  }

  std::optional<JobRecord> find(std::int64_t number) override {
    static const std::string sql = kSelectJobs + "WHERE number = $1";
    return first(sql, number);
  }

  std::vector<JobRecord> list(const JobPage& page) override {
    static const std::string sql = kSelectJobs + "WHERE number > $1 ORDER BY number LIMIT $2";
    constexpr std::size_t kMost = std::numeric_limits<std::int64_t>::max();
    const PostgresqlRows rows =
        connection_.execute(sql.c_str(), page.after, std::min(page.limit, kMost));
    std::vector<JobRecord> jobs;
    jobs.reserve(static_cast<std::size_t>(rows.size()));
    for (int row = 0; row < rows.size(); ++row) jobs.push_back(read_job_row(rows, row));
    return jobs;
  }

  OpenJobs open_jobs() override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT number, status, heartbeat FROM jobs WHERE status IN ('queued', 'running') "
        "ORDER BY number");
    OpenJobs open;
    for (int row = 0; row < rows.size(); ++row) {
      if (job_status_from(rows.text(row, 1)) == JobStatus::kQueued) {
        ++open.queued;
      } else {
        open.running.push_back({rows.integer(row, 0), rows.number(row, 2)});
      }
    }
    return open;
  }

  std::optional<JobRecord> find_claimable(std::span<const JobLease> expired) override {
    static const std::string sql =
        kSelectJobs +
        "WHERE (status = 'queued' OR (status = 'running' AND EXISTS (SELECT 1 FROM unnest($1, $2) "
        "AS expired (job, beat) WHERE expired.job = jobs.number AND expired.beat = "
        "jobs.heartbeat))) AND NOT EXISTS (SELECT 1 FROM jobs AS earlier WHERE earlier.map = "
        "jobs.map AND earlier.number < jobs.number AND earlier.status IN ('queued', 'running')) "
        "ORDER BY number LIMIT 1 FOR UPDATE OF jobs SKIP LOCKED";
    std::vector<std::int64_t> numbers;
    std::vector<std::uint64_t> heartbeats;
    for (const JobLease& lease : expired) {
      numbers.push_back(lease.job);
      heartbeats.push_back(lease.heartbeat);
    }
    const PostgresqlRows rows =
        connection_.execute(sql.c_str(), std::span<const std::int64_t>(numbers),
                            std::span<const std::uint64_t>(heartbeats));
    if (rows.empty()) return std::nullopt;
    return read_job_row(rows, 0);
  }

  void update(const JobRecord& job) override {
    (void)connection_.execute(
        "UPDATE jobs SET status = $1, stage = $2, progress = $3, started = $4, finished = $5, "
        "problem = $6, cancelling = $7, attempts = $8, holder = $9, heartbeat = $10 "
        "WHERE number = $11",
        to_string(job.status), job.stage, std::optional(job.progress), job.started, job.finished,
        job.problem, job.is_cancelling, job.attempts, job.holder, job.heartbeat, job.number);
  }

  std::string answer(std::int64_t number) override {
    const PostgresqlRows rows =
        connection_.execute("SELECT answer FROM jobs WHERE number = $1", number);
    return rows.empty() ? std::string() : rows.text(0, 0);
  }

  void put_answer(std::int64_t number, std::string_view answer) override {
    (void)connection_.execute("UPDATE jobs SET answer = $1 WHERE number = $2", answer, number);
  }

  JobInput input(std::int64_t number) override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT name, content FROM job_inputs WHERE job = $1 ORDER BY name", number);
    JobInput input;
    for (int row = 0; row < rows.size(); ++row) input[rows.text(row, 0)] = rows.copy(row, 1);
    return input;
  }

  void insert_input(std::int64_t number, std::string_view name, BlobView content) override {
    (void)connection_.execute("INSERT INTO job_inputs (job, name, content) VALUES ($1, $2, $3)",
                              number, name, content);
  }

  void remove_input(std::int64_t number) override {
    (void)connection_.execute("DELETE FROM job_inputs WHERE job = $1", number);
  }

  void remove_finished_before(std::string_view time) override {
    (void)connection_.execute("DELETE FROM jobs WHERE finished <> '' AND finished < $1", time);
  }

 private:
  template <typename Key>
  std::optional<JobRecord> first(const std::string& sql, Key key) {
    const char* lock = connection_.is_writing() ? " FOR UPDATE OF jobs" : "";
    const PostgresqlRows rows = connection_.execute((sql + lock).c_str(), key);
    if (rows.empty()) return std::nullopt;
    return read_job_row(rows, 0);
  }

  PostgresqlConnection& connection_;
};

}  // namespace

std::unique_ptr<JobTables> make_job_tables(PostgresqlConnection& connection) {
  return std::make_unique<PostgresqlJobTables>(connection);
}

}  // namespace cornerfix::storage
