#include "evaluation/datasets/bag/binary_file.hpp"

#include <utility>

namespace cornerfix::evaluation {

Result<BinaryFile> BinaryFile::open(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream stream(path, std::ios::binary);
  if (error || !stream) return Error{ErrorCode::kNotFound, "cannot be opened", path.string()};
  return BinaryFile(std::move(stream), size);
}

Result<void> BinaryFile::read(std::size_t size, std::vector<std::byte>& out) {
  if (size <= rest()) {
    out.resize(size);
    // Streams know characters only.
    stream_.read(reinterpret_cast<char*>(out.data()),  // NOLINT
                 static_cast<std::streamsize>(size));
    if (stream_) {
      offset_ += size;
      return {};
    }
  }
  return Error{ErrorCode::kMalformed, "the file ends too early", ""};
}

bool BinaryFile::skip(std::uint64_t size) {
  if (size > rest()) return false;
  stream_.seekg(static_cast<std::streamoff>(size), std::ios::cur);
  offset_ += size;
  return static_cast<bool>(stream_);
}

double BinaryFile::progress() const {
  return size_ == 0 ? 1.0 : static_cast<double>(offset_) / static_cast<double>(size_);
}

}  // namespace cornerfix::evaluation
