/// \file  The lines of a text file, plain or gzip'd.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <cornerfix/result.hpp>

namespace cornerfix::evaluation {

/// Streams a file; holds one line and one block of it at a time. One thread at a time.
class LineReader {
 public:
  static constexpr std::size_t kMaxLineBytes = 16U << 20U;

  [[nodiscard]] static Result<LineReader> open(const std::filesystem::path& path);

  /// Moves on to the next line and returns true, or false at the end. A gzip'd file that ends
  /// before its end mark, and a line above kMaxLineBytes, are errors.
  [[nodiscard]] Result<bool> next();

  /// The current line without its end; its capacity() leaves room for simdjson's padding.
  [[nodiscard]] const std::string& line() const { return line_; }
  [[nodiscard]] std::size_t line_number() const { return line_number_; }  ///< From 1.
  /// Where the current line begins, in the unpacked text.
  [[nodiscard]] std::uint64_t line_offset() const { return line_offset_; }
  /// Share of the file read so far, in [0, 1].
  [[nodiscard]] double progress() const;

 private:
  struct CloseFile {
    void operator()(void* file) const;
  };

  LineReader(std::filesystem::path path, void* file);
  [[nodiscard]] Result<bool> fill();
  [[nodiscard]] Error error(std::string message) const;

  std::filesystem::path path_;
  std::unique_ptr<void, CloseFile> file_;  ///< gzFile; zlib.h stays in the source.
  std::uintmax_t file_bytes_ = 0;
  std::vector<char> block_;
  std::size_t block_at_ = 0;
  std::size_t block_end_ = 0;
  std::string line_;
  std::size_t line_number_ = 0;
  std::uint64_t line_offset_ = 0;
  std::uint64_t next_offset_ = 0;
};

}  // namespace cornerfix::evaluation
