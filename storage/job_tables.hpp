/// \file  The rows of jobs, as an engine stores them. For JobStore, which has the rules.
///
/// Functions throw; JobStore calls them under guarded().
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "storage/job_store.hpp"

namespace cornerfix::storage {

/// Of jobs that are not finished.
struct JobLoad {
  std::size_t jobs = 0;
  std::uint64_t input_bytes = 0;
};

class JobTables {
 public:
  JobTables() = default;
  virtual ~JobTables() = default;
  JobTables(const JobTables&) = delete;
  JobTables& operator=(const JobTables&) = delete;

  /// Returns the new number.
  virtual std::int64_t insert(const NewJob& job) = 0;
  virtual JobLoad load() = 0;
  virtual std::vector<JobCount> counts() = 0;
  virtual bool has_unfinished(std::string_view map) = 0;
  /// In a transaction that writes, other writers of the job then wait for its end.
  virtual std::optional<JobRecord> find(std::string_view id) = 0;
  virtual std::optional<JobRecord> find(std::int64_t number) = 0;
  virtual std::vector<JobRecord> list(const JobPage& page) = 0;
  virtual OpenJobs open_jobs() = 0;
  /// As JobStore::claim(), without the change. Jobs that others write are passed over.
  virtual std::optional<JobRecord> find_claimable(std::span<const JobLease> expired) = 0;
  /// What changes of a job; `started` and so on of the same number.
  virtual void update(const JobRecord& job) = 0;

  virtual std::string answer(std::int64_t number) = 0;
  virtual void put_answer(std::int64_t number, std::string_view answer) = 0;
  virtual JobInput input(std::int64_t number) = 0;
  virtual void insert_input(std::int64_t number, std::string_view name, BlobView content) = 0;
  virtual void remove_input(std::int64_t number) = 0;
  virtual void remove_finished_before(std::string_view time) = 0;
};

/// Of a text that to_string() made. Throws StorageError (kCorruptData) for another one.
[[nodiscard]] JobStatus job_status_from(std::string_view text);

}  // namespace cornerfix::storage
