#include "storage/blob_codec.hpp"

#include <zlib.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <new>
#include <optional>
#include <utility>

#include "storage/blob_fields.hpp"

namespace cornerfix::storage {
namespace {

// Version 1 knew neither sense nor sigma.
constexpr std::size_t kFeatureSize1 = 44;
constexpr std::size_t kFeatureSize = 53;
constexpr std::size_t kDescriptorEntrySize = 8;
constexpr std::size_t kSubmapScanKeySize = 12;
// What deflate can expand to at most (zlib's technical notes), so that a small BLOB cannot claim a
// huge grid.
constexpr std::uint64_t kMaxInflation = 1032;
constexpr std::uint64_t kMaxCells = 200'000'000;  // Twice what a map may have.

constexpr std::size_t scan_size(const LaserScan& scan) {
  constexpr std::size_t kFixedSize = 11 * sizeof(double) + sizeof(std::uint32_t);
  return kFixedSize + scan.ranges.size() * sizeof(float);
}

bool is_consistent(const DescriptorSet& set) {
  if (set.offsets.empty()) return set.entries.empty();
  const bool covers_entries = set.offsets.front() == 0 &&
                              set.offsets.back() == set.entries.size() &&
                              std::is_sorted(set.offsets.begin(), set.offsets.end());
  return covers_entries &&
         std::all_of(set.entries.begin(), set.entries.end(),
                     [&](const DescriptorEntry& entry) { return entry.feature < set.size(); });
}

/// The cells of a `width` x `height` grid, or nothing when `deflated` does not hold just these.
std::optional<std::vector<Cell>> inflate_cells(BlobView deflated, int width, int height) {
  if (width < 0 || height < 0) return std::nullopt;
  const std::uint64_t size = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  if (size > deflated.size() * kMaxInflation || size > kMaxCells) return std::nullopt;
  std::vector<Cell> cells(size);
  uLongf inflated_size = size;
  uLong consumed_size = deflated.size();
  const int status = ::uncompress2(reinterpret_cast<Bytef*>(cells.data()), &inflated_size,
                                   deflated.data(), &consumed_size);
  const bool exact = inflated_size == size && consumed_size == deflated.size();
  if (status != Z_OK || !exact) return std::nullopt;
  const bool known =
      std::all_of(cells.begin(), cells.end(), [](Cell cell) { return cell <= Cell::kUnknown; });
  return known ? std::optional(std::move(cells)) : std::nullopt;
}

constexpr std::size_t kGridHeaderSize = 4 * sizeof(double) + 8;

void put_grid_header(BlobWriter& writer, const OccupancyGrid& grid) {
  writer.real(grid.resolution);
  writer.pose(grid.T_map_grid);
  writer.signed_integer(grid.width);
  writer.signed_integer(grid.height);
}

void put_optional_real(BlobWriter& writer, const std::optional<double>& value) {
  writer.integer(static_cast<std::uint8_t>(value.has_value()));
  writer.real(value.value_or(0.0));
}

std::optional<double> take_optional_real(BlobReader& reader) {
  const bool present = reader.integer<std::uint8_t>() != 0;
  const double value = reader.real();
  return present ? std::optional(value) : std::nullopt;
}

void put_region(BlobWriter& writer, const std::optional<StartRegion>& region) {
  const StartRegion some = region.value_or(StartRegion{});
  writer.integer(static_cast<std::uint8_t>(region.has_value()));
  for (const double value : {some.center.x(), some.center.y(), some.radius_m}) writer.real(value);
  put_optional_real(writer, some.yaw);
  writer.real(some.yaw_tolerance_rad);
  writer.count(some.map.size());
  std::memcpy(writer.extend(some.map.size()), some.map.data(), some.map.size());
}

std::optional<StartRegion> take_region(BlobReader& reader) {
  const bool present = reader.integer<std::uint8_t>() != 0;
  StartRegion region;
  region.center.x() = reader.real();
  region.center.y() = reader.real();
  region.radius_m = reader.real();
  region.yaw = take_optional_real(reader);
  region.yaw_tolerance_rad = reader.real();
  const BlobView map = reader.bytes(reader.count(1));
  region.map.assign(map.begin(), map.end());
  return present ? std::optional(std::move(region)) : std::nullopt;
}

void put_optional_pose(BlobWriter& writer, const std::optional<Pose2>& pose) {
  writer.integer(static_cast<std::uint8_t>(pose.has_value()));
  writer.pose(pose.value_or(Pose2{}));
}

std::optional<Pose2> take_optional_pose(BlobReader& reader) {
  const bool present = reader.integer<std::uint8_t>() != 0;
  const Pose2 pose = reader.pose();
  return present ? std::optional(pose) : std::nullopt;
}

}  // namespace

Blob encode_key_frame(const PosedScan& key_frame) {
  BlobWriter writer(BlobKind::kKeyFrame, scan_size(key_frame.scan));
  writer.pose(key_frame.T_map_base_link);
  writer.pose(key_frame.T_base_link_laser);
  writer.scan(key_frame.scan);
  return std::move(writer).finish();
}

Result<PosedScan> decode_key_frame(BlobView blob) {
  Result<BlobReader> reader = open_blob(BlobKind::kKeyFrame, "key frame", blob);
  if (!reader) return reader.error();
  PosedScan key_frame;
  key_frame.T_map_base_link = reader->pose();
  key_frame.T_base_link_laser = reader->pose();
  key_frame.scan = reader->scan();
  if (!reader->finished()) return inconsistent("key frame");
  return key_frame;
}

Blob encode_features(std::span<const Feature> features) {
  BlobWriter writer(BlobKind::kFeatures, 4 + features.size() * kFeatureSize);
  writer.count(features.size());
  for (const Feature& feature : features) {
    for (const double value : {feature.position.x(), feature.position.y(), feature.turn_angle,
                               feature.bisector, feature.weight}) {
      writer.real(value);
    }
    writer.signed_integer(feature.count);
    writer.integer(static_cast<std::uint8_t>(feature.convex));
    writer.real(feature.sigma_m);
  }
  return std::move(writer).finish();
}

Result<std::vector<Feature>> decode_features(BlobView blob) {
  Result<BlobReader> reader = open_blob(BlobKind::kFeatures, "features", blob);
  if (!reader) return reader.error();
  const bool first_version = blob[0] == 1;
  std::vector<Feature> features(reader->count(first_version ? kFeatureSize1 : kFeatureSize));
  for (Feature& feature : features) {
    for (double* field : {&feature.position.x(), &feature.position.y(), &feature.turn_angle,
                          &feature.bisector, &feature.weight}) {
      *field = reader->real();
    }
    feature.count = reader->signed_integer();
    if (first_version) continue;
    feature.convex = reader->integer<std::uint8_t>() != 0;
    feature.sigma_m = reader->real();
  }
  if (!reader->finished()) return inconsistent("features");
  return features;
}

Blob encode_descriptors(const DescriptorSet& descriptors) {
  BlobWriter writer(BlobKind::kDescriptors, 3 * sizeof(double) + 8 +
                                                descriptors.offsets.size() * 4 +
                                                descriptors.entries.size() * kDescriptorEntrySize);
  const DescriptorParams& params = descriptors.params;
  for (const double value :
       {params.distance_resolution_m, params.angle_resolution_rad, params.max_distance_m}) {
    writer.real(value);
  }
  writer.count(descriptors.offsets.size());
  for (const std::uint32_t offset : descriptors.offsets) writer.integer(offset);
  writer.count(descriptors.entries.size());
  for (const DescriptorEntry& entry : descriptors.entries) {
    std::uint8_t* to = writer.extend(kDescriptorEntrySize);
    store_little_endian(to, entry.distance_bin);
    store_little_endian(to + 2, entry.angle_bin);
    store_little_endian(to + 4, entry.feature);
  }
  return std::move(writer).finish();
}

Result<DescriptorSet> decode_descriptors(BlobView blob) {
  Result<BlobReader> reader = open_blob(BlobKind::kDescriptors, "descriptors", blob);
  if (!reader) return reader.error();
  DescriptorSet set;
  for (double* field : {&set.params.distance_resolution_m, &set.params.angle_resolution_rad,
                        &set.params.max_distance_m}) {
    *field = reader->real();
  }
  set.offsets.resize(reader->count(sizeof(std::uint32_t)));
  for (std::uint32_t& offset : set.offsets) offset = reader->integer<std::uint32_t>();
  set.entries.resize(reader->count(kDescriptorEntrySize));
  const BlobView entries = reader->bytes(set.entries.size() * kDescriptorEntrySize);
  for (std::size_t i = 0; i < set.entries.size(); ++i) {
    const std::uint8_t* from = entries.data() + i * kDescriptorEntrySize;
    set.entries[i] = {load_little_endian<std::uint16_t>(from),
                      load_little_endian<std::uint16_t>(from + 2),
                      load_little_endian<std::uint32_t>(from + 4)};
  }
  if (!reader->finished() || !is_consistent(set)) return inconsistent("descriptors");
  return set;
}

Blob encode_grid_header(const OccupancyGrid& grid) {
  BlobWriter writer(BlobKind::kGrid, kGridHeaderSize);
  put_grid_header(writer, grid);
  return std::move(writer).finish();
}

Blob encode_grid(const OccupancyGrid& grid) {
  assert(grid.cells.size() ==
             static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height) &&
         "a grid holds width * height cells");
  uLongf deflated_size = ::compressBound(grid.cells.size());
  Blob deflated(deflated_size);
  // Fast: floor plans shrink to a few percent anyway.
  const int status = ::compress2(deflated.data(), &deflated_size,
                                 reinterpret_cast<const Bytef*>(grid.cells.data()),
                                 grid.cells.size(), Z_BEST_SPEED);
  if (status != Z_OK) throw std::bad_alloc();  // The only way left for zlib to fail.

  BlobWriter writer(BlobKind::kGrid, kGridHeaderSize + deflated_size);
  put_grid_header(writer, grid);
  std::copy_n(deflated.data(), deflated_size, writer.extend(deflated_size));
  return std::move(writer).finish();
}

Result<OccupancyGrid> decode_grid(BlobView blob) {
  Result<BlobReader> reader = open_blob(BlobKind::kGrid, "grid", blob);
  if (!reader) return reader.error();
  OccupancyGrid grid;
  grid.resolution = reader->real();
  grid.T_map_grid = reader->pose();
  grid.width = reader->signed_integer();
  grid.height = reader->signed_integer();
  std::optional<std::vector<Cell>> cells = inflate_cells(reader->rest(), grid.width, grid.height);
  if (!reader->finished() || !cells) return inconsistent("grid");
  grid.cells = std::move(*cells);
  return grid;
}

Blob encode_submap_scan(const SubmapScan& scan) {
  BlobWriter writer(BlobKind::kSubmapScan, sizeof(std::uint64_t) + scan_size(scan.scan));
  writer.integer(scan.index);
  writer.pose(scan.T_submap_base_link);
  writer.pose(scan.T_base_link_laser);
  writer.scan(scan.scan);
  return std::move(writer).finish();
}

Result<SubmapScan> decode_submap_scan(BlobView blob) {
  Result<BlobReader> reader = open_blob(BlobKind::kSubmapScan, "submap scan", blob);
  if (!reader) return reader.error();
  SubmapScan scan;
  scan.index = reader->integer<std::uint64_t>();
  scan.T_submap_base_link = reader->pose();
  scan.T_base_link_laser = reader->pose();
  scan.scan = reader->scan();
  if (!reader->finished()) return inconsistent("submap scan");
  return scan;
}

Blob encode_localizer_state(const LocalizerState& state, std::span<const SubmapScanKey> submap) {
  constexpr std::size_t kFixedSize = 361;
  BlobWriter writer(BlobKind::kLocalizerState, kFixedSize + submap.size() * kSubmapScanKeySize);
  writer.integer(state.next_index);
  writer.integer(state.scans);
  writer.pose(state.T_submap_base_link);
  writer.pose(state.last_motion);
  writer.real(state.last_interval_s);
  put_optional_real(writer, state.last_stamp);
  put_optional_pose(writer, state.last_T_odom_base_link);
  writer.integer(static_cast<std::uint8_t>(state.status));
  writer.integer(static_cast<std::uint8_t>(state.reason));
  writer.real(state.confidence);
  writer.signed_integer(state.tracked_map);
  writer.pose(state.T_map_submap);
  writer.signed_integer(state.misfits);
  writer.real(state.misfit_way_m);
  for (const double value : state.tracking_covariance) writer.real(value);
  put_optional_real(writer, state.usual_fit);
  put_optional_real(writer, state.usual_share);
  for (const double sum : state.odometry_sums) writer.real(sum);
  writer.integer(state.epoch);
  writer.integer(static_cast<std::uint8_t>(state.confirmed ? 1 : 0));
  writer.real(state.distance_since_acceptance_m);
  writer.real(state.searched_at_m);
  writer.integer(state.accepted_index);
  put_region(writer, state.region);
  writer.count(submap.size());
  for (const SubmapScanKey& key : submap) {
    writer.integer(key.index);
    writer.integer(key.checksum);
  }
  return std::move(writer).finish();
}

Result<LocalizerStateOutline> decode_localizer_state(BlobView blob) {
  Result<BlobReader> reader = open_blob(BlobKind::kLocalizerState, "localizer state", blob);
  if (!reader) return reader.error();
  LocalizerStateOutline outline;
  LocalizerState& state = outline.state;
  state.next_index = reader->integer<std::uint64_t>();
  state.scans = reader->integer<std::uint64_t>();
  state.T_submap_base_link = reader->pose();
  state.last_motion = reader->pose();
  state.last_interval_s = reader->real();
  if (blob[0] < 4) state.last_interval_s = 0.0;  // was the distance driven
  state.last_stamp = take_optional_real(*reader);
  state.last_T_odom_base_link = take_optional_pose(*reader);
  const auto status = reader->integer<std::uint8_t>();
  state.status = static_cast<Status>(status);
  const auto reason = reader->integer<std::uint8_t>();
  state.reason = static_cast<Reason>(reason);
  state.confidence = reader->real();
  state.tracked_map = reader->signed_integer();
  state.T_map_submap = reader->pose();
  state.misfits = reader->signed_integer();
  if (blob[0] > 1) {
    state.misfit_way_m = reader->real();
    for (double& value : state.tracking_covariance) value = reader->real();
    state.usual_fit = take_optional_real(*reader);
    state.usual_share = take_optional_real(*reader);
  }
  if (blob[0] > 2) {
    for (double& sum : state.odometry_sums) sum = reader->real();
    state.epoch = reader->integer<std::uint64_t>();
    state.confirmed = reader->integer<std::uint8_t>() != 0;
    state.distance_since_acceptance_m = reader->real();
    state.searched_at_m = reader->real();
    state.accepted_index = reader->integer<std::uint64_t>();
  }
  if (blob[0] > 4) state.region = take_region(*reader);
  outline.submap.resize(reader->count(kSubmapScanKeySize));
  for (SubmapScanKey& key : outline.submap) {
    key.index = reader->integer<std::uint64_t>();
    key.checksum = reader->integer<std::uint32_t>();
  }
  const bool known = status <= static_cast<std::uint8_t>(Status::kLost) &&
                     reason <= static_cast<std::uint8_t>(kLastReason);
  const bool has_bad_region = state.region && validate(*state.region).has_value();
  if (!reader->finished() || !known || has_bad_region) return inconsistent("localizer state");
  return outline;
}

}  // namespace cornerfix::storage
