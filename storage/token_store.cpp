#include "storage/token_store.hpp"

#include <SQLiteCpp/Database.h>
#include <openssl/evp.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "storage/database.hpp"
#include "storage/statement.hpp"

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

TokenHash hash_from(BlobView blob) {
  TokenHash hash{};
  std::copy_n(blob.begin(), std::min(blob.size(), hash.size()), hash.begin());
  return hash;
}

}  // namespace

TokenHash hash_of_token(std::string_view token) {
  TokenHash hash{};
  unsigned size = 0;
  if (EVP_Digest(token.data(), token.size(), hash.data(), &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("SHA-256 is not available");
  return hash;
}

TokenStore::TokenStore(std::shared_ptr<Database> database) : database_(std::move(database)) {}
TokenStore::~TokenStore() = default;
TokenStore::TokenStore(TokenStore&&) noexcept = default;

Result<std::int64_t> TokenStore::insert(const TokenRecord& token) {
  return guarded([&]() -> Result<std::int64_t> {
    WriteTransaction transaction(*database_);
    Statement(*database_,
              "INSERT INTO tokens (name, role, maps, hash, created, expires) "
              "VALUES (?, ?, ?, ?, ?, ?)")
        .bind(token.name, token.role, joined(token.maps), BlobView(token.hash), token.created,
              token.expires)
        .run();
    const std::int64_t id = database_->connection().getLastInsertRowid();
    transaction.commit();
    return id;
  });
}

Result<std::vector<TokenRecord>> TokenStore::list() {
  return guarded([&]() -> Result<std::vector<TokenRecord>> {
    Statement row(*database_,
                  "SELECT id, name, role, maps, hash, created, expires FROM tokens ORDER BY id");
    std::vector<TokenRecord> tokens;
    for (row.bind(); row.step();) {
      tokens.push_back({.id = row.integer(0),
                        .name = row.text(1),
                        .role = row.text(2),
                        .maps = split(row.text(3)),
                        .hash = hash_from(row.blob(4)),
                        .created = row.text(5),
                        .expires = row.text(6)});
    }
    return tokens;
  });
}

Result<void> TokenStore::remove(std::int64_t id) {
  return guarded([&]() -> Result<void> {
    WriteTransaction transaction(*database_);
    const int removed = Statement(*database_, "DELETE FROM tokens WHERE id = ?").bind(id).run();
    transaction.commit();
    if (removed == 1) return {};
    return Error{ErrorCode::kNotFound, "there is no token " + std::to_string(id), "token"};
  });
}

}  // namespace cornerfix::storage
