#include "evaluation/datasets/log_format.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "evaluation/datasets/line_reader.hpp"

namespace cornerfix::evaluation {

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
  // Only one that is packed with gzip: others are recognized by their first bytes.
  for (const char* bag : {".bag", ".mcap", ".db3"}) {
    if (extension == bag) return LogFormat::kBag;
  }
  return std::nullopt;
}

/// A file that must be unpacked first.
std::optional<std::string_view> packing(std::string_view bytes) {
  struct Packing {
    std::string_view magic;
    std::string_view name;
  };
  constexpr std::array kPackings = {
      Packing{"BZh", "bzip2"},
      Packing{"\xfd"
              "7zXZ\0"sv,
              "xz"},
      Packing{"\x04\x22\x4d\x18", "lz4"},
      Packing{"PK\x03\x04", "zip"},
      Packing{"7z\xbc\xaf", "7z"},
  };
  for (const Packing& packing : kPackings) {
    if (bytes.starts_with(packing.magic)) return packing.name;
  }
  return std::nullopt;
}

std::optional<LogFormat> format_of_line(std::string_view line) {
  if (line.starts_with("{")) return LogFormat::kJsonLines;
  for (const char* word : {"# CARMEN", "# message_name", "PARAM ", "SYNC ", "ODOM ", "FLASER ",
                           "RLASER ", "ROBOTLASER", "RAWLASER", "LASER_READING "}) {
    if (line.starts_with(word)) return LogFormat::kCarmen;
  }
  return std::nullopt;
}

/// Text of either kind is recognized by its first line that is no comment.
std::optional<LogFormat> format_by_first_line(const std::filesystem::path& path) {
  constexpr std::size_t kMostComments = 100;
  Result<LineReader> lines = LineReader::open(path);
  if (!lines) return std::nullopt;
  for (std::size_t i = 0; i < kMostComments; ++i) {
    const Result<bool> any = lines->next();
    if (!any || !*any) return std::nullopt;
    const std::string_view line = lines->line();
    if (const auto format = format_of_line(line)) return format;
    if (!line.empty() && !line.starts_with('#')) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

Result<LogFormat> detect_log_format(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return LogFormat::kBag;
  if (path.filename() == "metadata.yaml") return LogFormat::kBag;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)) {
    return Error{ErrorCode::kInvalidArgument,
                 "is no file but a pipe or a device, and a log is read more than once: write it to "
                 "a file first",
                 path.string()};
  }
  Result<std::string> bytes = first_bytes(path);
  if (!bytes) return bytes.error();
  if (bytes->empty()) return Error{ErrorCode::kMalformed, "is empty", path.string()};
  if (begins_as_bag(*bytes)) return LogFormat::kBag;
  if (const auto name = packing(*bytes)) {
    return Error{ErrorCode::kInvalidArgument,
                 "is packed with " + std::string(*name) + ": unpack it first", path.string()};
  }
  if (bytes->starts_with("#ROSBAG V")) {
    return Error{ErrorCode::kInvalidArgument,
                 "is a bag of format " + bytes->substr(9, 3) + ", expected 2.0: see rosbag fix",
                 path.string()};
  }
  if (bytes->starts_with("version https://")) {
    return Error{ErrorCode::kInvalidArgument,
                 "is a Git LFS pointer and not the file itself: see git lfs pull", path.string()};
  }
  const std::string extension = extension_without_gz(path);
  if (extension == ".tar" || extension == ".tgz") {
    return Error{ErrorCode::kInvalidArgument, "is an archive: unpack it first", path.string()};
  }
  const bool is_packed = path.extension() == ".gz";
  const auto by_extension = format_by_extension(extension);
  if (by_extension == LogFormat::kBag && is_packed) return LogFormat::kBag;
  // Many programs call any text a .log.
  if (const auto format = format_by_first_line(path)) return *format;
  if (by_extension && *by_extension != LogFormat::kBag) return *by_extension;
  return Error{ErrorCode::kInvalidArgument,
               "unknown kind of log, expected JSON lines (.jsonl) or CARMEN (.log, .clf, .gfs), "
               "also with .gz, or a bag of ROS (.bag, .mcap, .db3, also with .zstd or .gz, or a "
               "directory)",
               path.string()};
}

}  // namespace cornerfix::evaluation
