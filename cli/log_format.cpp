#include "cli/log_format.hpp"

#include <algorithm>
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
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, "cannot be opened", path.string()};
  std::array<char, 16> bytes{};
  file.read(bytes.data(), bytes.size());
  return std::string(bytes.data(), static_cast<std::size_t>(file.gcount()));
}

/// Also of what is packed with zstd: a bag of compression_mode file.
bool begins_as_bag(std::string_view bytes) {
  constexpr std::array kMagics = {"#ROSBAG V2.0"sv, "\x89MCAP0\r\n"sv, "SQLite format 3\0"sv,
                                  "\x28\xb5\x2f\xfd"sv};
  return std::ranges::any_of(kMagics, [&](auto magic) { return bytes.starts_with(magic); });
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

/// Text of either kind is recognized by its first line.
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
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return LogFormat::kBag;
  const Result<std::string> bytes = first_bytes(path);
  if (!bytes) return bytes.error();
  if (begins_as_bag(*bytes)) return LogFormat::kBag;
  if (bytes->starts_with("#ROSBAG V")) {
    return Error{ErrorCode::kInvalidArgument,
                 "is a bag of format " + bytes->substr(9, 3) + ", expected 2.0: see rosbag fix",
                 path.string()};
  }
  if (const auto format = format_by_extension(extension_without_gz(path))) return *format;
  if (const auto format = format_by_first_line(path)) return *format;
  return Error{
      ErrorCode::kInvalidArgument,
      "unknown kind of log, expected JSON lines (.jsonl) or CARMEN (.log, .clf, .gfs), "
      "also with .gz, or a bag of ROS (.bag, .mcap, .db3, also with .zstd, or a directory)",
      path.string()};
}

}  // namespace cornerfix::cli
