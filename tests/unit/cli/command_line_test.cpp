#include "cli/command_line.hpp"

#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "server/settings.hpp"
#include "support/fake_server.hpp"
#include "unit/cli/command_run.hpp"

namespace cornerfix::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class CommandLine : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
};

TEST_F(CommandLine, EndsWrongUseWithTwo) {
  const std::string log = directory_.write("a.jsonl", walk(3)).string();
  const std::string map = directory_.write("map.yaml", "").string();
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"dance"},
      {"map"},
      {"map", "build"},
      {"map", "build", "a"},
      {"map", "build", "a", "/no/such/log.jsonl"},
      {"map", "build", "a", log.c_str(), "--split", "2"},
      {"map", "build", "a", log.c_str(), "--stride", "0"},
      {"map", "build", "a", log.c_str(), "--db", "a.db", "--server", "http://127.0.0.1:1"},
      {"map", "build", "a", log.c_str(), "--db", "a.db", "--print-curl"},
      {"map", "show"},
      {"replay"},
      {"replay", log.c_str(), "--batch", "101"},
      {"replay", log.c_str(), "--from", "soon"},
      {"replay", log.c_str(), "--quickly"},
      {"simulate", map.c_str()},
      {"simulate", map.c_str(), "out.jsonl", "--beams", "1"},
      {"simulate", map.c_str(), "out.jsonl", "--fov", "400"},
      {"simulate", "/no/such/map.yaml", "out.jsonl"},
  };
  for (const auto& arguments : wrong) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << ::testing::PrintToString(arguments);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err, "");
  }
}

TEST_F(CommandLine, EndsHelpWithZero) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--help"}, {"map", "--help"}, {"map", "build", "--help"}, {"replay", "--help"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_THAT(outcome.out, HasSubstr("Usage:"));
  }
}

TEST_F(CommandLine, PrintsItsVersion) {
  const Outcome outcome = run({"--version"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, "cornerfix " CORNERFIX_VERSION "\n");
}

TEST_F(CommandLine, EndsWithOneWhatItCouldNotDo) {
  const std::string map = directory_.write("map.yaml", "resolution: 1").string();
  const Outcome outcome = run({"simulate", map.c_str(), "out.jsonl"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("image: missing"));
}

TEST_F(CommandLine, NamesTheCommandThatThereIsNot) {
  EXPECT_THAT(run({"dance"}).err, HasSubstr("there is no command dance\n"));
  EXPECT_THAT(run({"map", "dance", "--quickly"}).err, HasSubstr("there is no command dance\n"));
  EXPECT_THAT(run({"map"}).err, HasSubstr("subcommand is required"));
  EXPECT_THAT(run({"map", "show"}).err, HasSubstr("NAME is required"));
}

TEST_F(CommandLine, PrintsTheRangeOfANumberInAFewWords) {
  const std::string log = directory_.write("a.jsonl", walk(3)).string();
  for (const char* number : {"0", "-1", "inf", "many"}) {
    EXPECT_THAT(run({"evaluate", log.c_str(), "--starts", number}).err,
                HasSubstr("--starts: expected a number above 0, not " + std::string(number)));
  }
  EXPECT_THAT(run({"replay", log.c_str(), "--rate", "-1"}).err,
              HasSubstr("--rate: expected a number from 0 on, not -1"));
  EXPECT_THAT(run({"evaluate", "--help"}).out, Not(HasSubstr("0000000")));
}

TEST_F(CommandLine, RefusesANameThatNoMapCanHave) {
  const std::string log = directory_.write("walk.jsonl", walk(3)).string();
  const std::string database = (directory_.path() / "maps.db").string();
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"map", "build", "a/b", log.c_str(), "--db", database.c_str()},
           {"map", "restore", "a/b", log.c_str()},
           {"map", "show", "a/b"},
           {"replay", log.c_str(), "--map", "a/b"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("a/b is no name for a map"));
  }
  EXPECT_FALSE(std::filesystem::exists(database));
}

TEST_F(CommandLine, EndsWithTwoWhereAFileIsMissingOrADirectory) {
  const std::string directory = directory_.path().string();
  for (const auto& [file, says] :
       {std::pair("/no/such/file", "does not exist"), std::pair(directory.c_str(), "directory")}) {
    for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
             {"map", "restore", "a", file}, {"serve", "--db", "a.db", "--config", file}}) {
      const Outcome outcome = run(arguments);
      EXPECT_EQ(outcome.exit_code, 2);
      EXPECT_THAT(outcome.err, HasSubstr(says));
    }
  }
}

TEST_F(CommandLine, ListsEverySettingInTheHelpOfServe) {
  const Outcome outcome = run({"serve", "--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  ASSERT_FALSE(server::settings().empty());
  for (const server::Setting& setting : server::settings()) {
    EXPECT_THAT(outcome.out, HasSubstr(setting.flag()));
    EXPECT_THAT(outcome.out, HasSubstr(setting.variable()));
    EXPECT_THAT(outcome.out, HasSubstr(setting.default_value));
  }
}

TEST_F(CommandLine, TakesEverySettingAsAFlag) {
  const std::string file = directory_.write("config.json", "{").string();
  for (const server::Setting& setting : server::settings()) {
    const std::string flag = setting.flag();
    if (flag.empty()) continue;
    std::vector<std::string> arguments = {"serve", "--config", file.c_str(), flag.c_str()};
    if (setting.kind != server::Setting::Kind::kSwitch) arguments.push_back("1");
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("the configuration is not JSON")) << flag;
  }
}

TEST_F(CommandLine, NamesTheFlagOfAWrongSetting) {
  const Outcome outcome = run({"serve", "--db", "a.db", "--max-scans", "many"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--max-scans: expected an integer from 1 to"));
}

TEST_F(CommandLine, SaysThatADatabaseIsADirectory) {
  const std::string directory = directory_.path().string();
  const Outcome outcome = run({"serve", "--db", directory.c_str(), "--port", "0"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("is a directory"));
}

TEST_F(CommandLine, TakesHttpServersOnly) {
  const Outcome outcome = run({"map", "list", "--server", "ftp://x"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("not ftp://x"));
}

TEST_F(CommandLine, PrintsCurlLinesInsteadOfSending) {
  const std::string log = directory_.write("walk.jsonl", walk(3)).string();
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"map", "list"},
                                             {"map", "show", "a"},
                                             {"map", "delete", "a"},
                                             {"map", "build", "a", log.c_str()},
                                             {"replay", log.c_str()}}) {
    testing::FakeServer server([](const testing::FakeRequest&) {
      return testing::FakeAnswer{200, "{}"};
    });
    const std::string url = server.url();
    std::vector<std::string> printing = arguments;
    printing.insert(printing.end(), {"--print-curl", "--server", url.c_str()});
    const Outcome outcome = run(printing);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(server.requests().empty());
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_THAT(line, HasSubstr("curl -sS --fail-with-body"));
      EXPECT_THAT(line, HasSubstr(url + "/v1/"));
    }
  }
}

}  // namespace
}  // namespace cornerfix::cli
