#include "server/group_commit.hpp"

#include <exception>
#include <utility>

namespace cornerfix::server {

Result<void> GroupCommit::store(const storage::SessionChange& change) {
  Waiting mine{change, std::nullopt};
  std::unique_lock lock(mutex_);
  waiting_.push_back(&mine);
  written_.wait(lock, [&] { return mine.result || !is_writing_; });
  if (mine.result) return *mine.result;
  is_writing_ = true;
  const std::vector<Waiting*> group = std::exchange(waiting_, {});
  lock.unlock();
  std::vector<Result<void>> results = write_group(group);
  lock.lock();
  // Under the lock: the threads of the group may look at any time.
  for (std::size_t i = 0; i < group.size(); ++i) group[i]->result = std::move(results[i]);
  is_writing_ = false;
  lock.unlock();
  written_.notify_all();
  return *mine.result;
}

std::size_t GroupCommit::waiting() {
  const std::lock_guard lock(mutex_);
  return waiting_.size();
}

std::vector<Result<void>> GroupCommit::write_group(std::span<Waiting* const> group) const {
  std::vector<storage::SessionChange> changes;
  changes.reserve(group.size());
  for (const Waiting* each : group) changes.push_back(each->change);
  try {
    return write_(changes);
  } catch (const std::exception& exception) {  // The others must not wait for ever.
    const Error error{ErrorCode::kInternal, exception.what(), ""};
    std::vector<Result<void>> failed(group.size(), Result<void>(error));
    return failed;
  }
}

}  // namespace cornerfix::server
