/// \file  What an evaluation found, for files and for people.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "evaluation/metrics/localization_score.hpp"
#include "evaluation/metrics/report_score.hpp"

namespace cornerfix::evaluation {

/// The figures of the replay tool, by its names, and a few more.
[[nodiscard]] nlohmann::ordered_json summary_json(const std::string& log_name,
                                                  const Evaluation& evaluation,
                                                  const EvaluationOptions& options);

/// A start's record by the replay tool's names. Poses and ranges only if localized.
[[nodiscard]] nlohmann::ordered_json record_json(const StartRecord& record);

/// How well a localizability report predicts the starts.
[[nodiscard]] nlohmann::ordered_json report_score_json(const ReportScore& score);

/// A row per start.
void write_records(std::ostream& csv, const std::vector<StartRecord>& records);

/// A row per sample: the log's name, start, path length, distance to the mapped part, right or not,
/// and the class counts of the two best poses.
void write_samples(std::ostream& csv, const std::string& name,
                   const std::vector<StartRecord>& records, bool header);

}  // namespace cornerfix::evaluation
