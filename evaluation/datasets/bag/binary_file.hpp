/// \file  A file of records, read from front to back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <cornerfix/result.hpp>

namespace cornerfix::evaluation {

/// One thread at a time.
class BinaryFile {
 public:
  [[nodiscard]] static Result<BinaryFile> open(const std::filesystem::path& path);

  /// The next `size` bytes, or an error when the file does not hold as many: then nothing was
  /// allocated for them.
  [[nodiscard]] Result<void> read(std::size_t size, std::vector<std::byte>& out);
  /// Passes over them; false when the file does not hold as many.
  [[nodiscard]] bool skip(std::uint64_t size);

  [[nodiscard]] std::uint64_t offset() const { return offset_; }
  [[nodiscard]] std::uint64_t rest() const { return size_ - offset_; }
  [[nodiscard]] std::string place() const { return "byte " + std::to_string(offset_); }
  /// Share read so far, in [0, 1].
  [[nodiscard]] double progress() const;

 private:
  BinaryFile(std::ifstream stream, std::uint64_t size) : stream_(std::move(stream)), size_(size) {}

  std::ifstream stream_;
  std::uint64_t offset_ = 0;
  std::uint64_t size_;
};

}  // namespace cornerfix::evaluation
