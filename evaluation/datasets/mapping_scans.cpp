#include "evaluation/datasets/mapping_scans.hpp"

#include <utility>

namespace cornerfix::evaluation {

namespace {

std::size_t usable_scans(const LogSurvey& survey, const MappingScanOptions& options) {
  return options.without_poses ? survey.scans_in(options.split)
                               : survey.posed_scans_in(options.split);
}

Error no_usable_scan(const LogSurvey& survey, const MappingScanOptions& options,
                     const std::filesystem::path& path) {
  std::string message = options.without_poses ? "holds no scan" : "holds no scan with a pose";
  message += ", in " + std::to_string(survey.scans) + " scans";
  if (!options.without_poses) message += "; --slam does without poses";
  return {ErrorCode::kInvalidArgument, std::move(message), path.string()};
}

}  // namespace

MappingScans::MappingScans(LogReader reader, const LogSurvey& survey,
                           const MappingScanOptions& options)
    : reader_(std::move(reader)),
      remarks_(survey.remarks),
      stride_(options.stride),
      posed_only_(!options.without_poses),
      key_scans_only_(posed_only_ && survey.posed_key_scans > 0),
      wanted_(usable_scans(survey, options)) {}

Result<MappingScans> MappingScans::open(const std::filesystem::path& path,
                                        const MappingScanOptions& options,
                                        const std::function<void(double)>& progress) {
  const Result<LogSurvey> survey = survey_log(path, options.selection, options.stride, progress);
  if (!survey) return survey.error();
  if (usable_scans(*survey, options) == 0) return no_usable_scan(*survey, options, path);
  Result<LogReader> reader = LogReader::open(path, options.selection);
  if (!reader) return reader.error();
  return MappingScans(std::move(*reader), *survey, options);
}

std::optional<LogScan> MappingScans::next() {
  while (taken_ < wanted_) {
    std::optional<LogScan> scan = reader_.next();
    if (!scan) return scan;
    if (index_++ % stride_ != 0 || (posed_only_ && !scan->T_map_laser)) continue;
    ++taken_;
    if (key_scans_only_ && !scan->is_key_scan) continue;
    ++count_;
    return scan;
  }
  return std::nullopt;
}

std::vector<LogScan> MappingScans::next_batch(std::size_t size) {
  std::vector<LogScan> batch;
  while (batch.size() < size) {
    std::optional<LogScan> scan = next();
    if (!scan) break;
    batch.push_back(std::move(*scan));
  }
  return batch;
}

}  // namespace cornerfix::evaluation
