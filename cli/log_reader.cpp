#include "cli/log_reader.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "cli/line_reader.hpp"
#include "cli/scan_parser.hpp"

namespace cornerfix::cli {

namespace {

/// The file's name without ".gz" and its own extension, and that extension.
std::pair<std::string, std::string> split_name(std::filesystem::path path) {
  path = path.filename();
  if (path.extension() == ".gz") path = path.stem();
  return {path.stem().string(), path.extension().string()};
}

std::unique_ptr<ScanParser> parser_for(const std::string& extension) {
  if (extension == ".jsonl") return make_json_lines_parser();
  constexpr std::array kCarmen = {".log", ".clf", ".gfs"};
  if (std::find(kCarmen.begin(), kCarmen.end(), extension) != kCarmen.end()) {
    return make_carmen_parser();
  }
  return nullptr;
}

}  // namespace

LogReader::LogReader(std::unique_ptr<LineReader> lines, std::unique_ptr<ScanParser> parser,
                     std::filesystem::path path)
    : path_(std::move(path)), lines_(std::move(lines)), parser_(std::move(parser)) {}
LogReader::~LogReader() = default;
LogReader::LogReader(LogReader&&) noexcept = default;

Result<LogReader> LogReader::open(const std::filesystem::path& path) {
  std::unique_ptr<ScanParser> parser = parser_for(split_name(path).second);
  if (parser == nullptr) {
    return Error{ErrorCode::kInvalidArgument,
                 "unknown kind of log, expected .jsonl, .log, .clf or .gfs, also with .gz",
                 path.string()};
  }
  Result<LineReader> lines = LineReader::open(path);
  if (!lines) return lines.error();
  LogReader reader(std::make_unique<LineReader>(std::move(*lines)), std::move(parser), path);
  Result<std::optional<LogScan>> first = reader.parse_next();
  if (!first) return first.error();
  if (!*first) return Error{ErrorCode::kMalformed, "holds no scan", path.string()};
  reader.first_ = std::move(*first);
  return reader;
}

const LogHeader& LogReader::header() const { return parser_->header(); }

double LogReader::progress() const { return lines_->progress(); }

Result<std::optional<LogScan>> LogReader::next() {
  if (first_) return std::exchange(first_, std::nullopt);
  return parse_next();
}

Result<std::optional<LogScan>> LogReader::parse_next() {
  while (true) {
    const Result<bool> more = lines_->next();
    if (!more) return more.error();
    if (!*more) return std::optional<LogScan>();
    Result<std::optional<LogScan>> scan = parser_->parse(lines_->line());
    if (!scan) {
      return Error{scan.error().code,
                   "line " + std::to_string(lines_->line_number()) + ": " + scan.error().message,
                   path_.string()};
    }
    if (*scan) return scan;
  }
}

Result<RecordedLog> read_log(const std::filesystem::path& path, std::size_t stride) {
  Result<LogReader> reader = LogReader::open(path);
  if (!reader) return reader.error();
  RecordedLog log;
  log.header = reader->header();
  if (log.header.name.empty()) log.header.name = split_name(path).first;
  for (std::size_t index = 0;; ++index) {
    Result<std::optional<LogScan>> scan = reader->next();
    if (!scan) return scan.error();
    if (!*scan) return log;
    if (index % stride == 0) log.scans.push_back(std::move(**scan));
  }
}

}  // namespace cornerfix::cli
