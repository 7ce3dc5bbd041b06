/// \file  Unpacks bags, their chunks and messages. The one place that knows libbz2, liblz4 and
/// libzstd; gzip is zlib's.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include <cornerfix/result.hpp>

namespace cornerfix::evaluation {

/// A chunk above this is not unpacked: writers begin a new one after a megabyte or few.
inline constexpr std::size_t kMaxChunkBytes = std::size_t{256} << 20U;

/// \param compression  "none" or "", "bz2", "lz4" (frame format) or "zstd".
/// \param size         Unpacked, as the bag says. More or fewer bytes are an error, and memory is
///                     taken as they come, so that a wrong size takes none.
[[nodiscard]] Result<std::vector<std::byte>> decompress(std::string_view compression,
                                                        std::span<const std::byte> packed,
                                                        std::size_t size);

/// Whether the bytes begin as a frame of zstd. A message in CDR never does.
[[nodiscard]] bool is_zstd(std::span<const std::byte> bytes);

/// A message that was packed as a whole, as rosbag2's compression_mode message does it. An error
/// above kMaxChunkBytes.
[[nodiscard]] Result<std::vector<std::byte>> decompress_message(std::span<const std::byte> packed);

[[nodiscard]] bool is_gzip(std::span<const std::byte> bytes);
/// As far as the predicates above need them; fewer where the file is shorter.
[[nodiscard]] std::vector<std::byte> magic_bytes(const std::filesystem::path& path);

/// Unpacks a file of zstd frames, or of gzip, into another one.
[[nodiscard]] Result<void> decompress_file(const std::filesystem::path& packed,
                                           const std::filesystem::path& unpacked);

}  // namespace cornerfix::evaluation
