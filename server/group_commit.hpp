/// \file  Joins changes that wait for the database at the same time.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <cornerfix/result.hpp>

#include "storage/session_store.hpp"

namespace cornerfix::server {

/// A change is written at once when no other one is being written. Those that come meanwhile are
/// written together afterwards, by one of their threads. Any threads may call.
class GroupCommit {
 public:
  using Write = std::function<std::vector<Result<void>>(std::span<const storage::SessionChange>)>;

  /// `write` is called by one thread at a time, with a session at most once.
  explicit GroupCommit(Write write) : write_(std::move(write)) {}

  /// Returns when the change is stored or refused. A session has one caller at a time.
  [[nodiscard]] Result<void> store(const storage::SessionChange& change);

  /// Changes that wait for the one that is being written.
  [[nodiscard]] std::size_t waiting();

 private:
  struct Waiting {
    storage::SessionChange change;
    std::optional<Result<void>> result;
  };

  [[nodiscard]] std::vector<Result<void>> write_group(std::span<Waiting* const> group) const;

  const Write write_;
  std::mutex mutex_;
  std::condition_variable written_;
  std::vector<Waiting*> waiting_;
  bool is_writing_ = false;
};

}  // namespace cornerfix::server
