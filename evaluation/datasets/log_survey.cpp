#include "evaluation/datasets/log_survey.hpp"

namespace cornerfix::evaluation {

Result<LogSurvey> survey_log(const std::filesystem::path& path, const LogSelection& selection,
                             std::size_t stride, const std::function<void(double)>& progress) {
  Result<LogReader> reader = LogReader::open(path, selection);
  if (!reader) return reader.error();
  LogSurvey survey;
  for (std::size_t index = 0; const auto scan = reader->next(); ++index) {
    if (progress) progress(reader->progress());
    if (index % stride != 0) continue;
    ++survey.scans;
    if (!scan->T_map_laser) continue;
    ++survey.posed_scans;
    if (scan->is_key_scan) ++survey.posed_key_scans;
  }
  if (auto error = reader->most_scans_lost()) return *error;
  survey.remarks = remarks(*reader);
  return survey;
}

}  // namespace cornerfix::evaluation
