#include "server/store_health.hpp"

#include <algorithm>
#include <utility>

namespace cornerfix::server {
namespace {

constexpr std::chrono::milliseconds kPatience{500};
constexpr std::chrono::seconds kShortestPause{1};
constexpr int kPausePerLook = 20;

}  // namespace

PageCheck::PageCheck(std::shared_ptr<const storage::Database> database)
    : database_(std::move(database)) {}

PageCheck::~PageCheck() {
  is_cancelled_ = true;
  if (look_.valid()) look_.wait();
}

Result<void> PageCheck::result() {
  const std::lock_guard lock(mutex_);
  if (!look_.valid() && Clock::now() >= next_) {
    look_ = std::async(std::launch::async, [this] {
      const auto begin = Clock::now();
      Result<void> checked = database_->check_pages(is_cancelled_);
      return Look{std::move(checked), Clock::now() - begin};
    });
    take_when_done(kPatience);
  } else if (look_.valid()) {
    take_when_done(std::chrono::milliseconds(0));
  }
  return last_;
}

void PageCheck::take_when_done(std::chrono::milliseconds patience) {
  if (look_.wait_for(patience) != std::future_status::ready) return;
  Look look = look_.get();
  last_ = std::move(look.result);
  next_ = Clock::now() + std::max<Clock::duration>(kShortestPause, kPausePerLook * look.duration);
}

Result<void> OncePerSecond::result(const Test& test) {
  if (Clock::now() < next_) return last_;
  last_ = test();
  next_ = Clock::now() + kShortestPause;
  return last_;
}

}  // namespace cornerfix::server
