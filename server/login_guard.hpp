/// \file  Locks out addresses that try one wrong token after the other.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>

#include "storage/token_store.hpp"

namespace cornerfix::server {

struct LoginLimits {
  std::size_t wrong_tokens = 20;     ///< Of an address within `window`; the next begins a lock-out.
  std::chrono::seconds window{60};   ///< From the first of them.
  std::chrono::seconds lockout{60};  ///< How long it lasts.
};

/// A wrong token that is sent again and again counts once: a robot whose token has expired locks
/// nobody out. A token that was accepted from an address stays accepted there during a lock-out, so
/// robots behind one proxy go on. Any threads may call.
class LoginGuard {
 public:
  using Clock = std::chrono::steady_clock;

  explicit LoginGuard(LoginLimits limits) : limits_(limits) {}

  /// How long the address must wait before it may try `credentials`; nothing when it may.
  [[nodiscard]] std::optional<std::chrono::seconds> must_wait(std::string_view address,
                                                              std::string_view credentials,
                                                              Clock::time_point now);
  void note_accepted(std::string_view address, std::string_view credentials);
  /// Whether this begins a lock-out.
  bool note_wrong(std::string_view address, std::string_view credentials, Clock::time_point now);

 private:
  struct Address {
    std::set<storage::TokenHash> wrong;
    Clock::time_point window_end{};
    Clock::time_point locked_until{};
    /// Hashes that only decide who need not wait: they need not withstand an attacker.
    std::unordered_set<std::size_t> accepted;
  };

  Address& address_of(std::string_view address);

  const LoginLimits limits_;
  std::mutex mutex_;
  std::map<std::string, Address, std::less<>> addresses_;
};

}  // namespace cornerfix::server
