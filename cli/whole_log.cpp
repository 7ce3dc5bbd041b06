#include "cli/whole_log.hpp"

#include "cli/command.hpp"
#include "cli/progress.hpp"

namespace cornerfix::cli {

Result<RecordedLog> read_whole_log(const std::string& path, const LogSelection& selection,
                                   std::size_t stride) {
  Result<LogReader> reader = LogReader::open(path, selection);
  if (!reader) return reader.error();
  RecordedLog log;
  {
    Progress progress("reading");
    log = read_all(*reader, stride, [&](double share) { progress.update(share); });
  }
  if (auto error = reader->most_scans_lost()) return *error;
  warn(path, remarks(*reader));
  return log;
}

}  // namespace cornerfix::cli
