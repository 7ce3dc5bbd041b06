#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "cli/command.hpp"
#include "server/environment.hpp"
#include "server/server_process.hpp"
#include "server/settings.hpp"

namespace cornerfix::cli {

namespace {

using server::ConfigSource;
using server::Setting;

/// Adds the environment, which flags override.
void add_environment(ConfigSource& source) {
  server::Environment environment = server::read_environment(environ);
  for (const std::string& name : environment.unknown) warn(name, "no such setting; ignored");
  if (!source.file) source.file = environment.config_file;
  source.overrides.insert(source.overrides.begin(), environment.overrides.begin(),
                          environment.overrides.end());
}

int run_serve(ConfigSource& source) {
  add_environment(source);
  const auto config = server::load_config(source.file, source.overrides);
  if (!config) {
    fail(config.error());
    return config.error().code == ErrorCode::kNotFound ? kCouldNot : kWrongUse;
  }
  const auto ended = server::run_server_process(*config, source, [](const std::string& url) {
    std::printf("listening on %s\n", url.c_str());
    std::fflush(stdout);
  });
  return ended ? kDone : fail(ended.error());
}

std::string help_of(const Setting& setting) {
  std::string help = setting.meaning;
  if (!setting.default_value.empty()) help += " (" + setting.default_value + ")";
  return help + "; " + setting.variable();
}

void add_setting(CLI::App& command, const Setting& setting, ConfigSource& source) {
  const std::string flag = setting.flag();
  const auto add = [&source, key = setting.key, flag](const std::string& text) {
    source.overrides.push_back({key, text, flag});
  };
  if (setting.kind == Setting::Kind::kSwitch) {
    command.add_flag_function(
        flag, [add](std::int64_t count) { add(count > 0 ? "true" : "false"); }, help_of(setting));
    return;
  }
  const bool is_integer = setting.kind == Setting::Kind::kInteger;
  const bool is_list = setting.kind == Setting::Kind::kNames;
  // The database has the name that it has in every command, too.
  const std::string names = setting.key == "database" ? "--db," + flag : flag;
  command.add_option_function<std::string>(names, add, help_of(setting))
      ->type_name(is_integer ? "N"
                  : is_list  ? "NAME,..."
                             : "TEXT");
}

}  // namespace

void add_serve_command(CLI::App& app, int& exit_code) {
  auto source = std::make_shared<ConfigSource>();
  CLI::App* command = app.add_subcommand("serve", "Run the server until SIGTERM or Ctrl-C");
  command
      ->add_option("--config", source->file, "JSON file with any of the settings; CORNERFIX_CONFIG")
      ->check(CLI::ExistingFile);
  std::string without_flag;
  for (const Setting& setting : server::settings()) {
    if (!setting.flag().empty()) {
      add_setting(*command, setting, *source);
    } else {
      without_flag += "\n  " + setting.variable() + "  " + setting.meaning;
    }
  }
  command->footer(
      "Flags override variables of the environment, which override the file. An empty variable is "
      "not set.\nSettings without a flag, since every user of a machine sees the arguments of "
      "programs:" +
      without_flag);
  command->callback([source, &exit_code] { exit_code = run_serve(*source); });
}

}  // namespace cornerfix::cli
