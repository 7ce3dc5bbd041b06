/// \file  The files that an evaluation writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <cornerfix/result.hpp>

#include "evaluation/metrics/explanation.hpp"
#include "evaluation/metrics/localization_score.hpp"
#include "evaluation/metrics/single_scan.hpp"

namespace cornerfix::evaluation {

/// `summary` and the record of each start.
[[nodiscard]] Result<void> write_evaluation(const std::string& path,
                                            const nlohmann::ordered_json& summary,
                                            const std::vector<StartRecord>& records);
[[nodiscard]] Result<void> write_evaluation(const std::string& path,
                                            const nlohmann::ordered_json& summary,
                                            const std::vector<SingleScanRecord>& records);

/// A row per start.
[[nodiscard]] Result<void> write_record_table(const std::string& path,
                                              const std::vector<StartRecord>& records);

/// Rows join those of earlier calls, so that one file gathers many logs.
[[nodiscard]] Result<void> append_samples(const std::string& path, const std::string& name,
                                          const std::vector<StartRecord>& records);

/// `directory`/start_N.json and, if the map was searched, `directory`/start_N.png.
[[nodiscard]] Result<void> write_explanation(const std::filesystem::path& directory,
                                             const Explanation& explanation,
                                             const LocalizationMap* right_map);

}  // namespace cornerfix::evaluation
