#include "cli/mapping_scans.hpp"

#include <utility>

namespace cornerfix::cli {

MappingScans::MappingScans(LogReader reader, const LogSurvey& survey,
                           const MappingScanOptions& options)
    : reader_(std::move(reader)),
      remarks_(survey.remarks),
      stride_(options.stride),
      wanted_posed_(survey.posed_scans_in(options.split)),
      key_scans_only_(survey.posed_key_scans > 0) {}

Result<MappingScans> MappingScans::open(const std::filesystem::path& path,
                                        const MappingScanOptions& options) {
  const Result<LogSurvey> survey = survey_log(path, options.lidar, options.stride);
  if (!survey) return survey.error();
  if (survey->posed_scans_in(options.split) == 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "holds no scan with a pose, in " + std::to_string(survey->scans) + " scans",
                 path.string()};
  }
  Result<LogReader> reader = LogReader::open(path, options.lidar);
  if (!reader) return reader.error();
  return MappingScans(std::move(*reader), *survey, options);
}

std::optional<LogScan> MappingScans::next() {
  while (posed_ < wanted_posed_) {
    std::optional<LogScan> scan = reader_.next();
    if (!scan) return scan;
    if (index_++ % stride_ != 0 || !scan->T_map_laser) continue;
    ++posed_;
    if (key_scans_only_ && !scan->is_key_scan) continue;
    ++count_;
    return scan;
  }
  return std::nullopt;
}

}  // namespace cornerfix::cli
