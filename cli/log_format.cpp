#include "cli/log_format.hpp"

#include <array>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "cli/line_reader.hpp"

namespace cornerfix::cli {

namespace {

using namespace std::string_view_literals;

/// What the file begins with; shorter where the file is.
Result<std::string> first_bytes(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    return Error{ErrorCode::kInvalidArgument,
                 "is a directory, expected a file; of a ROS 2 bag the .db3 or .mcap file in it",
                 path.string()};
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, "cannot be opened", path.string()};
  std::array<char, 16> bytes{};
  file.read(bytes.data(), bytes.size());
  return std::string(bytes.data(), static_cast<std::size_t>(file.gcount()));
}

std::optional<LogFormat> format_by_magic(std::string_view bytes) {
  if (bytes.starts_with("#ROSBAG V2.0")) return LogFormat::kRos1Bag;
  if (bytes.starts_with("\x89MCAP0\r\n"sv)) return LogFormat::kMcap;
  if (bytes.starts_with("SQLite format 3\0"sv)) return LogFormat::kSqliteBag;
  return std::nullopt;
}

std::string extension_without_gz(std::filesystem::path path) {
  if (path.extension() == ".gz") path = path.stem();
  return path.extension().string();
}

std::optional<LogFormat> format_by_extension(const std::string& extension) {
  if (extension == ".jsonl") return LogFormat::kJsonLines;
  for (const char* carmen : {".log", ".clf", ".gfs"}) {
    if (extension == carmen) return LogFormat::kCarmen;
  }
  return std::nullopt;
}

/// Text of either kind tells itself by its first line.
std::optional<LogFormat> format_by_first_line(const std::filesystem::path& path) {
  Result<LineReader> lines = LineReader::open(path);
  if (!lines) return std::nullopt;
  const Result<bool> any = lines->next();
  if (!any || !*any) return std::nullopt;
  const std::string_view line = lines->line();
  if (line.starts_with("{")) return LogFormat::kJsonLines;
  for (const char* word : {"# CARMEN", "# message_name", "PARAM ", "SYNC ", "ODOM ", "FLASER ",
                           "RLASER ", "ROBOTLASER", "RAWLASER", "LASER_READING "}) {
    if (line.starts_with(word)) return LogFormat::kCarmen;
  }
  return std::nullopt;
}

}  // namespace

Result<LogFormat> detect_log_format(const std::filesystem::path& path) {
  const Result<std::string> bytes = first_bytes(path);
  if (!bytes) return bytes.error();
  if (const auto format = format_by_magic(*bytes)) return *format;
  if (bytes->starts_with("#ROSBAG V")) {
    return Error{ErrorCode::kInvalidArgument,
                 "is a bag of format " + bytes->substr(9, 3) + ", expected 2.0: see rosbag fix",
                 path.string()};
  }
  if (const auto format = format_by_extension(extension_without_gz(path))) return *format;
  if (const auto format = format_by_first_line(path)) return *format;
  return Error{ErrorCode::kInvalidArgument,
               "unknown kind of log, expected JSON lines (.jsonl) or CARMEN (.log, .clf, .gfs), "
               "also with .gz, or an unpacked bag of ROS (.bag, .mcap, .db3)",
               path.string()};
}

}  // namespace cornerfix::cli
