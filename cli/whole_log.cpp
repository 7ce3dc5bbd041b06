#include "cli/whole_log.hpp"

#include "cli/command.hpp"
#include "cli/progress.hpp"

namespace cornerfix::cli {

Result<evaluation::RecordedLog> read_whole_log(const std::string& path,
                                               const evaluation::LogSelection& selection,
                                               std::size_t stride) {
  Result<evaluation::LogReader> reader = evaluation::LogReader::open(path, selection);
  if (!reader) return reader.error();
  evaluation::RecordedLog log;
  {
    Progress progress("reading");
    log = evaluation::read_all(*reader, stride, [&](double share) { progress.update(share); });
  }
  if (auto error = reader->most_scans_lost()) return *error;
  warn(path, evaluation::remarks(*reader));
  return log;
}

}  // namespace cornerfix::cli
