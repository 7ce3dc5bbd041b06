/// \file  Core types as versioned little-endian BLOBs; docs/storage-schema.md has the layout.
///
/// Every BLOB begins with its version and kind and ends with a CRC-32. Bytes that are foreign, cut
/// short, too long or damaged are kCorruptData: never a crash, nor more memory than they can
/// justify. Decoding gives back bit for bit what was encoded. Stateless: any thread may call.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <cornerfix/localizer.hpp>
#include <cornerfix/map_sketch.hpp>
#include <cornerfix/mapper.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix::storage {

using Blob = std::vector<std::uint8_t>;
using BlobView = std::span<const std::uint8_t>;

/// The CRC-32 at the end of a BLOB that an encode function made.
[[nodiscard]] std::uint32_t checksum_of(BlobView blob);

[[nodiscard]] Blob encode_key_frame(const PosedScan& key_frame);
[[nodiscard]] Result<PosedScan> decode_key_frame(BlobView blob);

[[nodiscard]] Blob encode_features(std::span<const Feature> features);
[[nodiscard]] Result<std::vector<Feature>> decode_features(BlobView blob);

[[nodiscard]] Blob encode_descriptors(const DescriptorSet& descriptors);
/// Offsets and feature indices are checked: the set can be used without further tests.
[[nodiscard]] Result<DescriptorSet> decode_descriptors(BlobView blob);

[[nodiscard]] Blob encode_grid(const OccupancyGrid& grid);
[[nodiscard]] Result<OccupancyGrid> decode_grid(BlobView blob);
/// What encode_grid() writes before the cells, as a BLOB of its own: for hashing.
[[nodiscard]] Blob encode_grid_header(const OccupancyGrid& grid);

[[nodiscard]] Blob encode_map_sketch(const MapSketch& sketch);
/// Sizes and numbers are checked: the sketch can be used without further tests.
[[nodiscard]] Result<MapSketch> decode_map_sketch(BlobView blob);

[[nodiscard]] Blob encode_submap_scan(const SubmapScan& scan);
[[nodiscard]] Result<SubmapScan> decode_submap_scan(BlobView blob);

/// Names a stored submap scan. `index` alone repeats after a reset; the checksum of its BLOB
/// distinguishes such scans.
struct SubmapScanKey {
  std::uint64_t index = 0;
  std::uint32_t checksum = 0;
  friend bool operator==(const SubmapScanKey&, const SubmapScanKey&) = default;
};

/// A localizer's state with the names of its submap scans in place of the scans.
struct LocalizerStateOutline {
  LocalizerState state;  ///< `submap` is empty.
  std::vector<SubmapScanKey> submap;
};

/// `state.submap` is left out; `submap` names its scans.
[[nodiscard]] Blob encode_localizer_state(const LocalizerState& state,
                                          std::span<const SubmapScanKey> submap);
[[nodiscard]] Result<LocalizerStateOutline> decode_localizer_state(BlobView blob);

}  // namespace cornerfix::storage
