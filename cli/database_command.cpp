#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "cli/command.hpp"
#include "storage/database_copy.hpp"

namespace cornerfix::cli {

namespace {

struct DatabaseCopyArguments {
  std::string from;
  std::string to;
};

/// A database that is there: opening a file that does not exist would make it.
Result<std::shared_ptr<storage::Database>> open_source(const std::string& location) {
  std::error_code error;
  if (!storage::is_postgresql(location) && !std::filesystem::exists(location, error))
    return Error{ErrorCode::kNotFound, "does not exist", location};
  return storage::Database::open(location, storage::Synchronous::kFull);
}

int run_database_copy(const DatabaseCopyArguments& arguments) {
  const auto from = open_source(arguments.from);
  if (!from) return fail(from.error());
  const auto to = storage::Database::open(arguments.to, storage::Synchronous::kFull);
  if (!to) return fail(to.error());
  const auto copied = storage::copy_database(*from, *to);
  if (!copied) return fail(copied.error());
  std::printf("%zu maps, %zu sessions, %zu tokens: copied to %s and checked\n", copied->maps,
              copied->sessions, copied->tokens, (*to)->location().c_str());
  return kDone;
}

}  // namespace

void add_database_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DatabaseCopyArguments>();
  CLI::App* command = app.add_subcommand("database", "Move a database to another engine");
  command->require_subcommand(1);
  CLI::App* copy_command = command->add_subcommand(
      "copy", "Copy all maps, sessions and tokens, and check the copy; stop the servers first");
  copy_command->add_option("FROM", arguments->from, "An SQLite file, or postgresql://…")
      ->required();
  copy_command->add_option("TO", arguments->to, "The same; made when it does not exist, else empty")
      ->required();
  copy_command->callback([arguments, &exit_code] { exit_code = run_database_copy(*arguments); });
}

}  // namespace cornerfix::cli
