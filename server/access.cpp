#include "server/access.hpp"

#include <algorithm>
#include <cctype>

namespace cornerfix::server {
namespace {

/// Takes the same time wherever the texts differ, so a token cannot be guessed byte by byte.
bool equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return difference == 0;
}

/// The credentials of the scheme "Bearer", whose name has no case (RFC 9110, 11.1).
std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view kScheme = "bearer ";
  if (authorization.size() < kScheme.size()) return {};
  const auto scheme = authorization.substr(0, kScheme.size());
  const bool is_bearer = std::ranges::equal(scheme, kScheme, {}, [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  if (!is_bearer) return {};
  authorization.remove_prefix(kScheme.size());
  const auto first = authorization.find_first_not_of(' ');
  return first == std::string_view::npos ? std::string_view{} : authorization.substr(first);
}

}  // namespace

bool may(Role role, Access access) {
  switch (access) {
    case Access::kPublic:
    case Access::kRead:
      return true;
    case Access::kSession:
      return role == Role::kRobot || role == Role::kAdmin;
    case Access::kMap:
      return role == Role::kMapper || role == Role::kAdmin;
  }
  return false;
}

bool Principal::may_use(std::string_view map) const {
  return maps.empty() || std::ranges::find(maps, map) != maps.end();
}

TokenTable::TokenTable(std::vector<Token> tokens, const std::vector<storage::TokenRecord>& stored)
    : tokens_(std::move(tokens)) {
  for (const storage::TokenRecord& token : stored) {
    const auto role = role_from(token.role);
    if (!role) continue;  // Of a newer program.
    stored_.emplace(token.hash, StoredToken{{*role, token.name, token.maps}, token.expires});
  }
}

std::optional<Principal> TokenTable::identify(std::string_view authorization,
                                              std::string_view now) const {
  if (is_empty()) return Principal{};
  const std::string_view given = bearer_token(authorization);
  std::optional<Principal> found;
  for (const Token& token : tokens_) {
    if (equal_in_constant_time(token.token, given)) found = Principal{token.role, token.name};
  }
  if (found || given.empty()) return found;
  const auto stored = stored_.find(storage::hash_of_token(given));
  if (stored == stored_.end()) return std::nullopt;
  const bool has_expired = !stored->second.expires.empty() && stored->second.expires <= now;
  if (has_expired) return std::nullopt;
  return stored->second.holder;
}

}  // namespace cornerfix::server
