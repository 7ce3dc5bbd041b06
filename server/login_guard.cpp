#include "server/login_guard.hpp"

#include <functional>

namespace cornerfix::server {
namespace {

// Bounds of the memory; beyond them all is forgotten, which only ends lock-outs early.
constexpr std::size_t kMaxAddresses = 20'000;
constexpr std::size_t kMaxAcceptedPerAddress = 20'000;

}  // namespace

LoginGuard::Address& LoginGuard::address_of(std::string_view address) {
  const auto known = addresses_.find(address);
  if (known != addresses_.end()) return known->second;
  if (addresses_.size() >= kMaxAddresses) addresses_.clear();
  return addresses_.emplace(address, Address{}).first->second;
}

std::optional<std::chrono::seconds> LoginGuard::must_wait(std::string_view address,
                                                          std::string_view credentials,
                                                          Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const auto found = addresses_.find(address);
  if (found == addresses_.end() || now >= found->second.locked_until) return std::nullopt;
  if (found->second.accepted.contains(std::hash<std::string_view>{}(credentials)))
    return std::nullopt;
  return std::chrono::ceil<std::chrono::seconds>(found->second.locked_until - now);
}

void LoginGuard::note_accepted(std::string_view address, std::string_view credentials) {
  const std::lock_guard lock(mutex_);
  Address& known = address_of(address);
  if (known.accepted.size() >= kMaxAcceptedPerAddress) known.accepted.clear();
  known.accepted.insert(std::hash<std::string_view>{}(credentials));
}

bool LoginGuard::note_wrong(std::string_view address, std::string_view credentials,
                            Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  Address& known = address_of(address);
  if (now >= known.window_end) {
    known.wrong.clear();
    known.window_end = now + limits_.window;
  }
  known.wrong.insert(storage::hash_of_token(credentials));
  if (known.wrong.size() <= limits_.wrong_tokens) return false;
  known.wrong.clear();
  known.locked_until = now + limits_.lockout;
  return true;
}

}  // namespace cornerfix::server
