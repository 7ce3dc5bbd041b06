#include "evaluation/datasets/line_reader.hpp"

#include <simdjson.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

namespace cornerfix::evaluation {

namespace {

constexpr std::size_t kBlockBytes = 256U << 10U;

gzFile as_gz(void* file) { return static_cast<gzFile>(file); }

}  // namespace

void LineReader::CloseFile::operator()(void* file) const { gzclose(as_gz(file)); }

Result<LineReader> LineReader::open(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    return Error{ErrorCode::kInvalidArgument, "is a directory, expected a file", path.string()};
  }
  errno = 0;
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) return Error{ErrorCode::kNotFound, std::strerror(errno), path.string()};
  return LineReader(path, file);
}

LineReader::LineReader(std::filesystem::path path, void* file)
    : path_(std::move(path)), file_(file), block_(kBlockBytes) {
  std::error_code error;
  file_bytes_ = std::filesystem::file_size(path_, error);
  if (error) file_bytes_ = 0;
}

Error LineReader::error(std::string message) const {
  return {ErrorCode::kMalformed, std::move(message), path_.string()};
}

/// False at the end of the file.
Result<bool> LineReader::fill() {
  const int count = gzread(as_gz(file_.get()), block_.data(), static_cast<unsigned>(kBlockBytes));
  int code = Z_OK;
  const char* message = gzerror(as_gz(file_.get()), &code);
  if (count < 0 || (count == 0 && code == Z_BUF_ERROR)) {
    return error(code == Z_BUF_ERROR ? "the compressed file ends too early" : message);
  }
  block_at_ = 0;
  block_end_ = static_cast<std::size_t>(count);
  return count > 0;
}

Result<bool> LineReader::next() {
  ++line_number_;
  line_offset_ = next_offset_;
  line_.clear();
  bool ended = false;
  while (!ended) {
    if (block_at_ == block_end_) {
      const Result<bool> filled = fill();
      if (!filled) return filled.error();
      if (!*filled) break;
    }
    const char* const begin = block_.data() + block_at_;
    const char* const end = block_.data() + block_end_;
    const char* const newline = std::find(begin, end, '\n');
    ended = newline != end;
    line_.append(begin, newline);
    next_offset_ += static_cast<std::uint64_t>(newline - begin) + (ended ? 1 : 0);
    block_at_ = static_cast<std::size_t>(newline - block_.data()) + (ended ? 1 : 0);
    if (line_.size() > kMaxLineBytes) return error("longer than 16 MiB");
  }
  if (!ended && line_.empty()) return false;
  if (line_number_ == 1) {
    if (line_.starts_with("\xff\xfe") || line_.starts_with("\xfe\xff")) {
      return error("is text in UTF-16, expected UTF-8");
    }
    if (line_.starts_with("\x1f\x8b")) return error("is packed with gzip twice: unpack it once");
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (line_.starts_with(kByteOrderMark)) line_.erase(0, kByteOrderMark.size());
  }
  if (!line_.empty() && line_.back() == '\r') line_.pop_back();
  line_.reserve(line_.size() + simdjson::SIMDJSON_PADDING);
  return true;
}

double LineReader::progress() const {
  if (file_bytes_ == 0) return 0.0;
  const auto read = static_cast<double>(gzoffset(as_gz(file_.get())));
  return std::clamp(read / static_cast<double>(file_bytes_), 0.0, 1.0);
}

}  // namespace cornerfix::evaluation
