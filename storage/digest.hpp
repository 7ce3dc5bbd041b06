/// \file  The SHA-256 of a map's content: the same content has the same digest in any database.
///
/// Keyframes are hashed in a chain, so that a map that grows is not read again from its start.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "storage/blob_codec.hpp"

namespace cornerfix::storage {

/// SHA-256 over a map's keyframes in order; of none: all zero.
using KeyFrameChain = std::array<std::uint8_t, 32>;

/// The chain with one more keyframe, given as the BLOB of encode_key_frame().
[[nodiscard]] KeyFrameChain extend(const KeyFrameChain& chain, BlobView key_frame);

/// What stands for the chain of a map that was made from an occupancy map: the SHA-256 of the
/// grid's numbers and cells, however a BLOB packs them.
[[nodiscard]] KeyFrameChain hash_of(const OccupancyGrid& floor_map);

/// Hex digest of a map with these parameters (hashed as they are spelled) and keyframes, which may
/// stand at poses whose drift is yet to be taken away.
[[nodiscard]] std::string map_digest(std::string_view parameters_json, const KeyFrameChain& chain,
                                     bool drifts = false);

}  // namespace cornerfix::storage
