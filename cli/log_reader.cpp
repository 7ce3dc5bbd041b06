#include "cli/log_reader.hpp"

#include <cstdio>
#include <utility>

#include "cli/log_format.hpp"
#include "cli/log_source.hpp"

namespace cornerfix::cli {

namespace {

/// The file's name without ".gz" and its own extension.
std::string plain_name(std::filesystem::path path) {
  path = path.filename();
  if (path.extension() == ".gz") path = path.stem();
  return path.stem().string();
}

Result<std::unique_ptr<LogSource>> open_source(const std::filesystem::path& path,
                                               const std::string& lidar) {
  const Result<LogFormat> format = detect_log_format(path);
  if (!format) return format.error();
  switch (*format) {
    case LogFormat::kJsonLines:
      return open_json_lines_log(path);
    case LogFormat::kCarmen:
      return open_carmen_log(path, lidar);
    case LogFormat::kRos1Bag:
      return open_ros1_bag(path, lidar);
    case LogFormat::kMcap:
      return open_mcap(path, lidar);
    case LogFormat::kSqliteBag:
      return open_sqlite_bag(path, lidar);
  }
  return Error{ErrorCode::kInternal, "format without reader", path.string()};
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6f s", seconds);
  return text;
}

/// "3 broken records left out, the first at line 7, byte 120: FLASER: expected 180 ranges".
std::string faults_text(const LogFaults& faults) {
  const LogFault& first = faults.first().front();
  return std::to_string(faults.count()) +
         (faults.count() == 1 ? " broken record" : " broken records") + " left out, the first at " +
         first.where + ": " + first.message;
}

}  // namespace

LogReader::LogReader(std::unique_ptr<LogSource> source, const std::filesystem::path& path)
    : source_(std::move(source)), name_(plain_name(path)) {}
LogReader::~LogReader() = default;
LogReader::LogReader(LogReader&&) noexcept = default;

Result<LogReader> LogReader::open(const std::filesystem::path& path, const std::string& lidar) {
  Result<std::unique_ptr<LogSource>> source = open_source(path, lidar);
  if (!source) return source.error();
  LogReader reader(std::move(*source), path);
  reader.first_ = reader.next_in_order();
  if (!reader.first_) {
    const std::string which = lidar.empty() ? "" : " of " + lidar;
    const std::string why = remarks(reader);
    return Error{ErrorCode::kMalformed, "holds no scan" + which + (why.empty() ? "" : "; " + why),
                 path.string()};
  }
  reader.header_ = reader.source_->header();
  if (reader.header_.name.empty()) reader.header_.name = reader.name_;
  return reader;
}

const LogHeader& LogReader::header() const { return header_; }

double LogReader::progress() const { return source_->progress(); }

const std::vector<std::string>& LogReader::notes() const { return source_->notes(); }

std::optional<LogScan> LogReader::next() {
  if (first_) return std::exchange(first_, std::nullopt);
  return next_in_order();
}

std::optional<LogScan> LogReader::next_in_order() {
  while (true) {
    std::optional<LogScan> scan = source_->next(faults_);
    if (!scan) return scan;
    if (!last_stamp_ || scan->scan.stamp > *last_stamp_) {
      last_stamp_ = scan->scan.stamp;
      return scan;
    }
    faults_.add("stamp " + seconds_text(scan->scan.stamp),
                "not after " + seconds_text(*last_stamp_) + " of the scan before");
  }
}

std::string remarks(const LogReader& reader) {
  std::string text;
  for (const std::string& note : reader.notes()) text += (text.empty() ? "" : "; ") + note;
  if (reader.faults().count() == 0) return text;
  return text + (text.empty() ? "" : "; ") + faults_text(reader.faults());
}

RecordedLog read_all(LogReader& reader, std::size_t stride,
                     const std::function<void(double)>& progress) {
  RecordedLog log;
  log.header = reader.header();
  std::size_t index = 0;
  while (std::optional<LogScan> scan = reader.next()) {
    if (index++ % stride == 0) log.scans.push_back(std::move(*scan));
    if (progress) progress(reader.progress());
  }
  return log;
}

Result<RecordedLog> read_log(const std::filesystem::path& path, std::size_t stride) {
  Result<LogReader> reader = LogReader::open(path);
  if (!reader) return reader.error();
  return read_all(*reader, stride);
}

}  // namespace cornerfix::cli
