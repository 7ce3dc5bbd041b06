/// \file  Unpacks the chunks of bags. The one place that knows libbz2, liblz4 and libzstd.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <cornerfix/result.hpp>

namespace cornerfix::cli {

/// A chunk above this is not unpacked: writers begin a new one after a megabyte or few.
inline constexpr std::size_t kMaxChunkBytes = std::size_t{256} << 20U;

/// \param compression  "none" or "", "bz2", "lz4" (frame format) or "zstd".
/// \param size         Unpacked, as the bag says. More or fewer bytes are an error, and memory is
///                     taken as they come, so that a wrong size takes none.
[[nodiscard]] Result<std::vector<std::byte>> decompress(std::string_view compression,
                                                        std::span<const std::byte> packed,
                                                        std::size_t size);

}  // namespace cornerfix::cli
