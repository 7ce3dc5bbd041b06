#include <algorithm>

#include "storage/postgresql/postgresql_connection.hpp"
#include "storage/postgresql/postgresql_tables.hpp"

namespace cornerfix::storage {
namespace {

class PostgresqlTokenTables : public TokenTables {
 public:
  explicit PostgresqlTokenTables(PostgresqlConnection& connection) : connection_(connection) {}

  std::int64_t insert(const TokenRow& row) override {
    const TokenRecord& token = row.token;
    const PostgresqlRows rows = connection_.execute(
        "INSERT INTO tokens (id, name, role, maps, hash, created, expires) "
        "VALUES (coalesce(nullif($1, 0), nextval('tokens_id_seq')), $2, $3, $4, $5, $6, $7) "
        "RETURNING id",
        token.id, token.name, token.role, row.maps, BlobView(token.hash), token.created,
        token.expires);
    return rows.integer(0, 0);
  }

  std::vector<TokenRow> list() override {
    const PostgresqlRows rows = connection_.execute(
        "SELECT id, name, role, maps, hash, created, expires FROM tokens ORDER BY id");
    std::vector<TokenRow> tokens;
    for (int row = 0; row < rows.size(); ++row) {
      TokenRow& added = tokens.emplace_back();
      added.token.id = rows.integer(row, 0);
      added.token.name = rows.text(row, 1);
      added.token.role = rows.text(row, 2);
      added.maps = rows.text(row, 3);
      const BlobView hash = rows.blob(row, 4);
      std::copy_n(hash.begin(), std::min(hash.size(), added.token.hash.size()),
                  added.token.hash.begin());
      added.token.created = rows.text(row, 5);
      added.token.expires = rows.text(row, 6);
    }
    return tokens;
  }

  bool remove(std::int64_t id) override {
    return connection_.execute("DELETE FROM tokens WHERE id = $1", id).changed() > 0;
  }

 private:
  PostgresqlConnection& connection_;
};

}  // namespace

std::unique_ptr<TokenTables> make_token_tables(PostgresqlConnection& connection) {
  return std::make_unique<PostgresqlTokenTables>(connection);
}

}  // namespace cornerfix::storage
