#include <cstdio>
#include <memory>
#include <string>

#include "cli/command.hpp"
#include "storage/sqlite/backup.hpp"

namespace cornerfix::cli {

namespace {

struct BackupArguments {
  std::string database;
  std::string target;
};

int run_backup(const BackupArguments& arguments) {
  const Result<void> done = storage::back_up(arguments.database, arguments.target);
  if (!done) return fail(done.error());
  std::printf("%s: copied to %s and checked\n", arguments.database.c_str(),
              arguments.target.c_str());
  return kDone;
}

}  // namespace

void add_backup_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<BackupArguments>();
  CLI::App* command = app.add_subcommand(
      "backup", "Copy a database, also one that a server has open, and check the copy");
  command->add_option("FILE", arguments->target, "The copy; must not exist")->required();
  command->add_option("--db", arguments->database, "The database of the server")
      ->required()
      ->check(CLI::ExistingFile);
  command->callback([arguments, &exit_code] { exit_code = run_backup(*arguments); });
}

}  // namespace cornerfix::cli
