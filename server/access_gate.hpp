/// \file  Who is let in: hosts, foreign pages, tokens, lock-outs, rates.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <variant>
#include <vector>

#include "server/access.hpp"
#include "server/host_check.hpp"
#include "server/http_message.hpp"
#include "server/login_guard.hpp"
#include "server/metrics.hpp"
#include "server/request_rate.hpp"
#include "server/server_config.hpp"
#include "server/store_access.hpp"

namespace cornerfix::server {

/// Who sends a request, and from where.
struct Caller {
  std::string address;
  bool is_reading = false;      ///< GET or HEAD.
  std::string authorization{};  ///< These are headers.
  std::string host{};
  std::vector<std::string> origins{};
  std::string fetch_site{};
};

/// Any threads may call.
class AccessGate {
 public:
  AccessGate(const ServerConfig& config, std::shared_ptr<StoreAccess> stores,
             std::shared_ptr<Metrics> metrics, NowText now);

  /// Those of the configuration and of the database, read anew when another process has changed it.
  /// When that fails, the old ones stay. A server with tokens does not become open when the last
  /// one is revoked. Null when they could never be read.
  [[nodiscard]] std::shared_ptr<const TokenTable> tokens();
  /// Replaces those of the configuration.
  void set_tokens(std::vector<Token> tokens);

  /// The caller, or the answer to one that is not let in.
  [[nodiscard]] std::variant<Principal, Response> admit(const Caller& caller, Access access);

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] std::optional<Response> refuse_foreign_page(const Caller& caller) const;
  [[nodiscard]] std::variant<Principal, Response> identify(const Caller& caller,
                                                           const TokenTable& known);
  [[nodiscard]] std::optional<Response> refuse_rate(const Caller& caller, const TokenTable& known,
                                                    const Principal& principal);

  HostCheck hosts_;  ///< Used where there are no tokens.
  std::shared_ptr<StoreAccess> stores_;
  std::shared_ptr<Metrics> metrics_;
  NowText now_;
  LoginGuard logins_;
  RequestRate rate_;
  std::mutex mutex_;
  std::vector<Token> configured_;
  std::shared_ptr<const TokenTable> tokens_;  ///< Of configuration and database.
  std::uint64_t epoch_ = 0;                   ///< Of the store when they were read.
};

}  // namespace cornerfix::server
