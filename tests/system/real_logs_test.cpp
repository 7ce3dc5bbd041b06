// Robots switched on all over recorded runs of real buildings, where these are at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "evaluation/datasets/log_reader.hpp"
#include "evaluation/metrics/localization_score.hpp"

namespace cornerfix::evaluation {
namespace {

namespace fs = std::filesystem;

/// The folder with `logs/`: named by CORNERFIX_DATA, or shared/data beside or above the sources.
std::optional<fs::path> data_folder() {
  if (const char* named = std::getenv("CORNERFIX_DATA")) return fs::path(named);
  for (fs::path folder = CORNERFIX_SOURCE_DIR; folder != folder.root_path();
       folder = folder.parent_path()) {
    if (fs::is_directory(folder / "shared" / "data")) return folder / "shared" / "data";
  }
  return std::nullopt;
}

/// Nothing, with the test marked as skipped, where the log is not.
std::optional<RecordedLog> read_real_log(const std::string& name) {
  const std::optional<fs::path> folder = data_folder();
  const fs::path path = folder.value_or("shared/data") / "logs" / (name + ".jsonl.gz");
  if (!fs::is_regular_file(path)) return std::nullopt;
  Result<RecordedLog> log = read_log(path);
  if (!log) ADD_FAILURE() << log.error().message;
  if (!log) return std::nullopt;
  return std::move(*log);
}

constexpr const char* kSkipped =
    "the recorded logs are not here: put them in shared/data/logs above the sources, or name the "
    "folder above logs/ in CORNERFIX_DATA";

struct Counts {
  std::size_t starts = 0;  ///< In mapped places, with enough of the log left to decide.
  std::size_t fixed = 0;
  std::size_t wrong = 0;
};

Counts count(const std::vector<StartRecord>& records, const EvaluationOptions& options) {
  Counts counts;
  for (const StartRecord& record : records) {
    if (!record.counts || record.near_m > options.near_m) continue;
    ++counts.starts;
    counts.fixed += record.verdict == Verdict::kCorrect ? 1 : 0;
    counts.wrong += record.verdict == Verdict::kWrong ? 1 : 0;
  }
  return counts;
}

std::string wrong_ones(const std::vector<StartRecord>& records) {
  std::string list;
  for (const StartRecord& record : records) {
    if (record.verdict != Verdict::kWrong) continue;
    list += "start " + std::to_string(record.start) + " off by " + std::to_string(record.error_m) +
            " m, " + std::to_string(record.error_rad) + " rad\n";
  }
  return list;
}

struct RealLog {
  std::string name;
  double split = 0.5;
  std::size_t batch = 5;
  Method method = Method::kIndexed;
  double min_success = 0.0;  ///< Clearly below what was measured.
  std::size_t max_wrong = 0;
};

void PrintTo(const RealLog& log, std::ostream* out) {
  *out << log.name << ", " << to_string(log.method);
}

EvaluationOptions options_of(const RealLog& log) {
  EvaluationOptions options;
  options.batch = log.batch;
  options.starts = 24;
  options.track_m = 2.0;
  options.threads = 2;
  options.localizer.method = log.method;
  return options;
}

class RealLogs : public ::testing::TestWithParam<RealLog> {};

TEST_P(RealLogs, FindTheRobotInTheMappedPart) {
  const std::optional<RecordedLog> log = read_real_log(GetParam().name);
  if (!log) GTEST_SKIP() << kSkipped;
  const EvaluationOptions options = options_of(GetParam());
  const std::size_t end = split_index(*log, GetParam().split);
  const Evaluation evaluation = map_from(*log, end, options.mapper);
  const std::vector<StartRecord> records =
      evaluate(*log, end, {evaluation.map}, 0, evaluation.mapping_positions, options, nullptr);
  const Counts counts = count(records, options);
  RecordProperty("starts", static_cast<int>(counts.starts));
  RecordProperty("fixed", static_cast<int>(counts.fixed));
  EXPECT_GE(counts.starts, 8U);
  EXPECT_GE(static_cast<double>(counts.fixed),
            GetParam().min_success * static_cast<double>(counts.starts))
      << counts.fixed << " of " << counts.starts;
  EXPECT_LE(counts.wrong, GetParam().max_wrong) << wrong_ones(records);
}

INSTANTIATE_TEST_SUITE_P(
    Logs, RealLogs,
    // Measured: rma 12 of 15, 10 of 10, 10 of 21; indexed all of them; none wrong.
    ::testing::Values(RealLog{"intel", 0.5, 5, Method::kRma, 0.5, 1},
                      RealLog{"freiburg_079", 0.7, 5, Method::kRma, 0.6, 1},
                      RealLog{"fhw", 0.4, 1, Method::kRma, 0.25, 1},
                      RealLog{"intel", 0.5, 5, Method::kIndexed, 0.8, 1},
                      RealLog{"freiburg_079", 0.7, 5, Method::kIndexed, 0.8, 1},
                      RealLog{"fhw", 0.4, 1, Method::kIndexed, 0.8, 1}),
    [](const auto& test) {
      return test.param.name + "_" + std::string(to_string(test.param.method));
    });

TEST(RealLogs, AnotherBuildingIsNotTakenForTheMappedOne) {
  const std::optional<RecordedLog> mapped = read_real_log("fhw");
  const std::optional<RecordedLog> asked = read_real_log("freiburg_079");
  if (!mapped || !asked) GTEST_SKIP() << kSkipped;
  const EvaluationOptions options = options_of({.name = "freiburg_079"});
  const Evaluation evaluation = map_from(*mapped, mapped->scans.size(), options.mapper);
  const std::vector<StartRecord> records =
      evaluate(*asked, 0, {evaluation.map}, kNoMap, {}, options, nullptr);
  EXPECT_EQ(std::ranges::count(records, Verdict::kWrong, &StartRecord::verdict), 0)
      << wrong_ones(records);
}

TEST(RealLogs, AMirroredRobotIsNotFound) {
  const std::optional<RecordedLog> log = read_real_log("freiburg_079");
  if (!log) GTEST_SKIP() << kSkipped;
  EvaluationOptions options = options_of({.name = "freiburg_079"});
  options.mirror = true;
  const std::size_t end = split_index(*log, 0.7);
  const Evaluation evaluation = map_from(*log, end, options.mapper);
  const std::vector<StartRecord> records =
      evaluate(*log, end, {evaluation.map}, 0, evaluation.mapping_positions, options, nullptr);
  EXPECT_EQ(std::ranges::count(records, Verdict::kWrong, &StartRecord::verdict), 0)
      << wrong_ones(records);
}

}  // namespace
}  // namespace cornerfix::evaluation
