/// \file  Who may do what: bearer tokens and their roles.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/server_config.hpp"

namespace cornerfix::server {

/// What a route asks of its caller.
enum class Access {
  kPublic,   ///< Nothing: health checks, the inspector's files.
  kRead,     ///< Any token.
  kSession,  ///< A robot, for its own sessions, or an admin.
  kAdmin,    ///< An admin.
};

/// The holder of a token.
struct Principal {
  Role role = Role::kAdmin;
  std::string name;

  /// Whether it may act on (or, being a robot, see) the sessions of `robot`.
  [[nodiscard]] bool may_see(std::string_view robot) const {
    return role != Role::kRobot || name == robot;
  }
};

[[nodiscard]] bool may(Role role, Access access);

/// Immutable, so any threads may share it.
class TokenTable {
 public:
  explicit TokenTable(std::vector<Token> tokens) : tokens_(std::move(tokens)) {}

  [[nodiscard]] bool is_empty() const { return tokens_.empty(); }
  /// The holder of the token in an Authorization header, or nothing when there is none or it is
  /// unknown. Without any tokens configured everybody is an admin.
  [[nodiscard]] std::optional<Principal> identify(std::string_view authorization) const;

 private:
  std::vector<Token> tokens_;
};

}  // namespace cornerfix::server
