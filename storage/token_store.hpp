/// \file  Access tokens in the database, as hashes only: who reads the file learns no token.
///
/// Each call is one transaction; not synchronised (one thread at a time).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <cornerfix/result.hpp>

namespace cornerfix::storage {

class Database;

/// SHA-256. Tokens have 256 random bits, so that a hash without salt cannot be searched.
using TokenHash = std::array<std::uint8_t, 32>;
[[nodiscard]] TokenHash hash_of_token(std::string_view token);
/// A new token. It begins with "cfx_", by which scanners for leaked secrets recognise it.
[[nodiscard]] std::string random_token();

struct TokenRecord {
  std::int64_t id = 0;              ///< Given by insert() where it is 0.
  std::string name;                 ///< Of the holder.
  std::string role;                 ///< As the server spells it; opaque here.
  std::vector<std::string> maps{};  ///< That the holder may use; empty: all.
  TokenHash hash{};
  std::string created{};  ///< RFC 3339, UTC.
  std::string expires{};  ///< The same; empty: never.
};

class TokenStore {
 public:
  explicit TokenStore(std::shared_ptr<Database> database);
  ~TokenStore();
  TokenStore(TokenStore&&) noexcept;

  [[nodiscard]] Result<std::int64_t> insert(const TokenRecord& token);
  [[nodiscard]] Result<std::vector<TokenRecord>> list();
  [[nodiscard]] Result<void> remove(std::int64_t id);  ///< kNotFound.

 private:
  std::shared_ptr<Database> database_;
};

}  // namespace cornerfix::storage
