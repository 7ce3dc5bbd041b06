#include "storage/token_store.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <utility>

#include "storage/database.hpp"
#include "storage/token_tables.hpp"

namespace cornerfix::storage {
namespace {

/// Names of maps hold no blanks.
std::string joined(const std::vector<std::string>& maps) {
  std::string text;
  for (const std::string& map : maps) text += (text.empty() ? "" : " ") + map;
  return text;
}

std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> maps;
  while (!text.empty()) {
    const auto end = std::min(text.find(' '), text.size());
    maps.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return maps;
}

}  // namespace

TokenHash hash_of_token(std::string_view token) {
  TokenHash hash{};
  unsigned size = 0;
  if (EVP_Digest(token.data(), token.size(), hash.data(), &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("SHA-256 is not available");
  return hash;
}

std::string random_token() {
  constexpr int kWords = 8;  // 256 bits
  std::random_device random;
  std::string token = "cfx_";
  for (int i = 0; i < kWords; ++i) {
    char word[9];
    std::snprintf(word, sizeof word, "%08x", random());
    token += word;
  }
  return token;
}

TokenStore::TokenStore(std::shared_ptr<Database> database) : database_(std::move(database)) {}
TokenStore::~TokenStore() = default;
TokenStore::TokenStore(TokenStore&&) noexcept = default;

Result<std::int64_t> TokenStore::insert(const TokenRecord& token) {
  return guarded([&]() -> Result<std::int64_t> {
    const auto transaction = database_->begin(Access::kWrite);
    const std::int64_t id = database_->tokens().insert({token, joined(token.maps)});
    transaction->commit();
    return id;
  });
}

Result<std::vector<TokenRecord>> TokenStore::list() {
  return guarded([&]() -> Result<std::vector<TokenRecord>> {
    std::vector<TokenRecord> tokens;
    for (TokenRow& row : database_->tokens().list()) {
      row.token.maps = split(row.maps);
      tokens.push_back(std::move(row.token));
    }
    return tokens;
  });
}

Result<void> TokenStore::remove(std::int64_t id) {
  return guarded([&]() -> Result<void> {
    const auto transaction = database_->begin(Access::kWrite);
    const bool was_there = database_->tokens().remove(id);
    transaction->commit();
    if (was_there) return {};
    return Error{ErrorCode::kNotFound, "there is no token " + std::to_string(id), "token"};
  });
}

}  // namespace cornerfix::storage
