#include <algorithm>

#include "storage/sqlite/sqlite_tables.hpp"
#include "storage/sqlite/statement.hpp"

namespace cornerfix::storage {
namespace {

class SqliteTokenTables : public TokenTables {
 public:
  explicit SqliteTokenTables(SqliteDatabase& database) : database_(database) {}

  std::int64_t insert(const TokenRow& row) override {
    const TokenRecord& token = row.token;
    Statement(database_,
              "INSERT INTO tokens (id, name, role, maps, hash, created, expires) "
              "VALUES (nullif(?, 0), ?, ?, ?, ?, ?, ?)")
        .bind(token.id, token.name, token.role, row.maps, BlobView(token.hash), token.created,
              token.expires)
        .run();
    return database_.last_row_id();
  }

  std::vector<TokenRow> list() override {
    Statement row(database_,
                  "SELECT id, name, role, maps, hash, created, expires FROM tokens ORDER BY id");
    std::vector<TokenRow> tokens;
    for (row.bind(); row.step();) {
      TokenRow& added = tokens.emplace_back();
      added.token.id = row.integer(0);
      added.token.name = row.text(1);
      added.token.role = row.text(2);
      added.maps = row.text(3);
      const BlobView hash = row.blob(4);
      std::copy_n(hash.begin(), std::min(hash.size(), added.token.hash.size()),
                  added.token.hash.begin());
      added.token.created = row.text(5);
      added.token.expires = row.text(6);
    }
    return tokens;
  }

  bool remove(std::int64_t id) override {
    return Statement(database_, "DELETE FROM tokens WHERE id = ?").bind(id).run() > 0;
  }

 private:
  SqliteDatabase& database_;
};

}  // namespace

std::unique_ptr<TokenTables> make_token_tables(SqliteDatabase& database) {
  return std::make_unique<SqliteTokenTables>(database);
}

}  // namespace cornerfix::storage
