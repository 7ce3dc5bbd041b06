/// \file  The header Prefer (RFC 7240).
#pragma once

#include <chrono>
#include <optional>
#include <string_view>

namespace cornerfix::server {

/// How a client wants a request with long work to be answered.
struct Preference {
  bool respond_async = false;                ///< At once, and the work as a job.
  std::optional<std::chrono::seconds> wait;  ///< For the work; then 202 all the same.
};

/// A client that waits longer holds a thread for too long.
inline constexpr std::chrono::seconds kMaxWait{60};

/// Adds what the value of one header says; the first of a kind counts. `wait` is cut to kMaxWait,
/// and other preferences are ignored, as the RFC allows.
void add_preference(Preference& preference, std::string_view header);

}  // namespace cornerfix::server
