#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "api/requests.hpp"
#include "cli/command.hpp"
#include "cli/table.hpp"
#include "server/service_setup.hpp"
#include "storage/database.hpp"
#include "storage/token_store.hpp"

namespace cornerfix::cli {

namespace {

struct TokenArguments {
  std::string database;
  std::string role;
  std::string name;
  std::vector<std::string> maps;
  int days = 0;
  std::int64_t id = 0;
};

std::string expiry_text(int days) {
  return days == 0 ? ""
                   : server::time_text(std::chrono::system_clock::now() + std::chrono::days(days));
}

Result<storage::TokenStore> open_tokens(const std::string& database) {
  auto opened = storage::Database::open(database, storage::Synchronous::kFull);
  if (!opened) return opened.error();
  return storage::TokenStore(std::move(*opened));
}

/// Of a database that is there. Only `create` makes one, before the first start of a server.
Result<storage::TokenStore> open_known_tokens(const std::string& database) {
  std::error_code error;
  if (!storage::is_postgresql(database) && !std::filesystem::exists(database, error))
    return Error{ErrorCode::kNotFound, "does not exist", database};
  return open_tokens(database);
}

int create(const TokenArguments& arguments) {
  Result<storage::TokenStore> tokens = open_tokens(arguments.database);
  if (!tokens) return fail(tokens.error());
  const std::string token = storage::random_token();
  const auto id = tokens->insert({.name = arguments.name,
                                  .role = arguments.role,
                                  .maps = arguments.maps,
                                  .hash = storage::hash_of_token(token),
                                  .created = server::now_text(),
                                  .expires = expiry_text(arguments.days)});
  if (!id) return fail(id.error());
  std::fprintf(stderr, "token %lld; it is shown only now:\n", static_cast<long long>(*id));
  std::printf("%s\n", token.c_str());
  return kDone;
}

int list(const TokenArguments& arguments) {
  Result<storage::TokenStore> tokens = open_known_tokens(arguments.database);
  if (!tokens) return fail(tokens.error());
  const auto records = tokens->list();
  if (!records) return fail(records.error());
  std::vector<std::vector<std::string>> rows = {
      {"id", "role", "name", "maps", "created", "expires"}};
  for (const storage::TokenRecord& token : *records) {
    std::string maps;
    for (const std::string& map : token.maps) maps += (maps.empty() ? "" : ",") + map;
    rows.push_back({std::to_string(token.id), token.role, token.name, maps.empty() ? "all" : maps,
                    token.created, token.expires.empty() ? "never" : token.expires});
  }
  print_table(rows);
  return kDone;
}

int revoke(const TokenArguments& arguments) {
  Result<storage::TokenStore> tokens = open_known_tokens(arguments.database);
  if (!tokens) return fail(tokens.error());
  const auto removed = tokens->remove(arguments.id);
  return removed ? kDone : fail(removed.error());
}

CLI::Validator holder_name() {
  return {[](const std::string& text) {
            return api::is_valid_name(text) ? "" : "expected [A-Za-z0-9][A-Za-z0-9._-]{0,127}";
          },
          "NAME"};
}

}  // namespace

void add_token_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<TokenArguments>();
  CLI::App* command = app.add_subcommand(
      "token", "Make and revoke access tokens; a running server takes them over at once");
  command->require_subcommand(1);
  CLI::App* create_command = command->add_subcommand("create", "Print a new token");
  CLI::App* list_command = command->add_subcommand("list", "Print who has tokens");
  CLI::App* revoke_command = command->add_subcommand("revoke", "Make a token useless");
  for (CLI::App* one : {create_command, list_command, revoke_command}) {
    one->add_option("--db", arguments->database, "The database of the server")->required();
  }
  create_command->add_option("--role", arguments->role, "viewer, robot, mapper or admin")
      ->required()
      ->check(CLI::IsMember({"viewer", "robot", "mapper", "admin"}));
  create_command
      ->add_option("--name", arguments->name, "Of the holder; of a robot, the robot's name")
      ->required()
      ->check(holder_name());
  create_command
      ->add_option("--map", arguments->maps, "A map that a robot may be looked for in (all)")
      ->check(map_name());
  create_command->add_option("--days", arguments->days, "Days until it expires; 0: never")
      ->check(CLI::Range(0, 36'500))
      ->capture_default_str();
  revoke_command->add_option("ID", arguments->id, "As `cornerfix token list` prints it")
      ->required();
  create_command->callback([arguments, &exit_code] { exit_code = create(*arguments); });
  list_command->callback([arguments, &exit_code] { exit_code = list(*arguments); });
  revoke_command->callback([arguments, &exit_code] { exit_code = revoke(*arguments); });
}

}  // namespace cornerfix::cli
