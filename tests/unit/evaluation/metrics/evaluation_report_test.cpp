#include "evaluation/metrics/evaluation_report.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace cornerfix::evaluation {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

/// The cell of the first row below a name of the header.
std::string cell(const std::string& csv, const std::string& name) {
  std::istringstream lines(csv);
  std::string header;
  std::string row;
  std::getline(lines, header);
  std::getline(lines, row);
  const std::vector<std::string> names = cells_of(header);
  const std::vector<std::string> values = cells_of(row);
  EXPECT_EQ(names.size(), values.size());
  const auto found = std::ranges::find(names, name);
  return found == names.end() ? "no column " + name
                              : values.at(static_cast<std::size_t>(found - names.begin()));
}

std::string csv_of(const DecisionSample& sample) {
  StartRecord record;
  record.start = 17;
  record.samples = {sample};
  std::ostringstream csv;
  write_samples(csv, "office", {record}, true);
  return csv.str();
}

DecisionSample sample_with_margin(double margin_per_hit, int hits) {
  DecisionSample sample;
  sample.best.ends = hits;
  sample.terms.margin_per_hit = margin_per_hit;
  return sample;
}

TEST(WriteSamples, NamesTheClassesOfHitsAndMisses) {
  DecisionSample sample;
  sample.best.end_counts.front() = 5;
  sample.best.end_counts.back() = 6;
  sample.best.matched = 0.25;
  sample.second.pass_counts.back() = 7;
  const std::string csv = csv_of(sample);
  EXPECT_EQ(cell(csv, "log"), "office");
  EXPECT_EQ(cell(csv, "start"), "17");
  EXPECT_EQ(cell(csv, "best_hits_wall_0.05"), "5");
  EXPECT_EQ(cell(csv, "best_hits_hidden"), "6");
  EXPECT_EQ(cell(csv, "best_matched"), "0.25");
  EXPECT_EQ(cell(csv, "second_hits_wall_0.05"), "0");
  EXPECT_EQ(cell(csv, "second_misses_unknown"), "7");
}

TEST(WriteSamples, StateWhetherTheMarginIsEnoughToAccept) {
  EXPECT_EQ(cell(csv_of(sample_with_margin(0.03, 200)), "has_margin"), "1");
  EXPECT_EQ(cell(csv_of(sample_with_margin(0.03, 50)), "has_margin"), "0") << "1.5 nat in all";
  EXPECT_EQ(cell(csv_of(sample_with_margin(0.01, 1000)), "has_margin"), "0") << "0.01 nat per hit";
}

TEST(WriteSamples, JoinsRowsOfAnotherLogWithoutAHeader) {
  std::ostringstream csv;
  write_samples(csv, "office", {}, true);
  write_samples(csv, "hall", {}, false);
  EXPECT_THAT(csv.str(), HasSubstr("log,start,"));
  EXPECT_EQ(std::ranges::count(csv.str(), '\n'), 1);
}

}  // namespace
}  // namespace cornerfix::evaluation
