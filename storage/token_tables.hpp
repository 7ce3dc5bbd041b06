/// \file  The rows of access tokens, as an engine stores them. For TokenStore.
///
/// Functions throw; TokenStore calls them under guarded().
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "storage/token_store.hpp"

namespace cornerfix::storage {

/// `maps` as one text with blanks between the names, instead of TokenRecord::maps.
struct TokenRow {
  TokenRecord token;
  std::string maps;
};

class TokenTables {
 public:
  TokenTables() = default;
  virtual ~TokenTables() = default;
  TokenTables(const TokenTables&) = delete;
  TokenTables& operator=(const TokenTables&) = delete;

  /// Returns the new id; a token that has one keeps it.
  virtual std::int64_t insert(const TokenRow& row) = 0;
  virtual std::vector<TokenRow> list() = 0;  ///< By id.
  virtual bool remove(std::int64_t id) = 0;
};

}  // namespace cornerfix::storage
