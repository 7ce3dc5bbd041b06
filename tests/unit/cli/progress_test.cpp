#include "cli/progress.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace cornerfix::cli {
namespace {

/// What is written while the shares are reported.
std::string written(bool is_terminal, const std::vector<double>& shares) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  {
    Progress progress("starts", file.get(), is_terminal);
    for (const double share : shares) progress.update(share);
  }
  std::rewind(file.get());
  std::string text(1000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  return text;
}

TEST(Progress, WritesALineAtEachTenthWhereNoTerminalIs) {
  EXPECT_EQ(written(false, {0.0, 0.04, 0.11, 0.12, 0.35, 1.0}),
            "starts: 0 %\nstarts: 10 %\nstarts: 30 %\nstarts: 100 %\n");
}

TEST(Progress, DrawsOneBarOnATerminalAndLeavesItsLine) {
  const std::string text = written(true, {0.5, 0.502, 1.0});
  EXPECT_EQ(text,
            "\rstarts [####################                    ]  50 %"
            "\rstarts [########################################] 100 %\n");
}

TEST(Progress, WritesNothingWhereNothingWasDone) { EXPECT_EQ(written(true, {}), ""); }

}  // namespace
}  // namespace cornerfix::cli
