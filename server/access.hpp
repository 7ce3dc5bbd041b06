/// \file  Who may do what: bearer tokens and their roles.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/server_config.hpp"
#include "storage/token_store.hpp"

namespace cornerfix::server {

/// What a route asks of its caller.
enum class Access {
  kPublic,   ///< Nothing: health checks, the inspector's files.
  kRead,     ///< Any token.
  kSession,  ///< A robot, for its own sessions, or an admin.
  kMap,      ///< A mapper or an admin.
};

/// The holder of a token.
struct Principal {
  Role role = Role::kAdmin;
  std::string name;
  std::vector<std::string> maps{};  ///< That a robot may be looked for in; empty: all.

  [[nodiscard]] bool may_use(std::string_view map) const;

  /// Whether it may act on (or, being a robot, see) the sessions of `robot`.
  [[nodiscard]] bool may_see(std::string_view robot) const {
    return role != Role::kRobot || name == robot;
  }
};

[[nodiscard]] bool may(Role role, Access access);

/// Immutable, so any threads may share it.
class TokenTable {
 public:
  explicit TokenTable(std::vector<Token> tokens,
                      const std::vector<storage::TokenRecord>& stored = {});

  [[nodiscard]] bool is_empty() const { return tokens_.empty() && stored_.empty(); }
  /// The holder of the token in an Authorization header, or nothing when there is none, or it is
  /// unknown or has expired at `now` (RFC 3339, UTC). Without any tokens everybody is an admin.
  [[nodiscard]] std::optional<Principal> identify(std::string_view authorization,
                                                  std::string_view now) const;

 private:
  struct StoredToken {
    Principal holder;
    std::string expires;
  };

  std::vector<Token> tokens_;
  std::map<storage::TokenHash, StoredToken> stored_;
};

}  // namespace cornerfix::server
