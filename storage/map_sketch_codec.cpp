// BLOBs of map sketches.
#include <algorithm>
#include <cmath>
#include <utility>

#include "storage/blob_codec.hpp"
#include "storage/blob_fields.hpp"

namespace cornerfix::storage {
namespace {

constexpr std::size_t kCornerSize = 4 * sizeof(float) + 1;
constexpr std::size_t kSketchFieldsSize = 5 * sizeof(double) + 3 * sizeof(std::uint32_t);
constexpr std::int64_t kMostSketchCells = 200'000'000;  // as many as a grid may have

bool has_finite_values(const SketchCorner& corner) {
  return std::isfinite(corner.x) && std::isfinite(corner.y) && std::isfinite(corner.bisector) &&
         std::isfinite(corner.turn_angle);
}

bool is_usable(const MapSketch& sketch) {
  const Pose2& pose = sketch.T_map_grid;
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw) &&
         std::isfinite(sketch.free_area_m2) && sketch.free_area_m2 >= 0.0 &&
         std::isfinite(sketch.cell_m) && sketch.cell_m >= 0.0 &&
         (sketch.cell_m > 0.0 || sketch.levels.empty()) &&
         std::ranges::all_of(sketch.corners, has_finite_values);
}

}  // namespace

Blob encode_map_sketch(const MapSketch& sketch) {
  BlobWriter writer(BlobKind::kMapSketch,
                    kSketchFieldsSize + sketch.levels.size() + sketch.corners.size() * kCornerSize);
  writer.pose(sketch.T_map_grid);
  writer.real(sketch.free_area_m2);
  writer.real(sketch.cell_m);
  writer.signed_integer(sketch.width);
  writer.signed_integer(sketch.height);
  std::ranges::copy(sketch.levels, writer.extend(sketch.levels.size()));
  writer.count(sketch.corners.size());
  for (const SketchCorner& corner : sketch.corners) {
    for (const float value : {corner.x, corner.y, corner.bisector, corner.turn_angle})
      writer.single(value);
    writer.integer(static_cast<std::uint8_t>(corner.convex ? 1 : 0));
  }
  return std::move(writer).finish();
}

Result<MapSketch> decode_map_sketch(BlobView blob) {
  Result<BlobReader> reader = open_blob(BlobKind::kMapSketch, "map sketch", blob);
  if (!reader) return reader.error();
  MapSketch sketch;
  sketch.T_map_grid = reader->pose();
  sketch.free_area_m2 = reader->real();
  sketch.cell_m = reader->real();
  sketch.width = reader->signed_integer();
  sketch.height = reader->signed_integer();
  const bool has_size = sketch.width >= 0 && sketch.height >= 0 &&
                        std::int64_t{sketch.width} * sketch.height <= kMostSketchCells;
  if (!has_size) return inconsistent("map sketch");
  const BlobView levels = reader->bytes(MapSketch::level_bytes(sketch.width, sketch.height));
  sketch.levels.assign(levels.begin(), levels.end());
  sketch.corners.resize(reader->count(kCornerSize));
  for (SketchCorner& corner : sketch.corners) {
    for (float* field : {&corner.x, &corner.y, &corner.bisector, &corner.turn_angle})
      *field = reader->single();
    corner.convex = reader->integer<std::uint8_t>() != 0;
  }
  if (!reader->finished() || !is_usable(sketch)) return inconsistent("map sketch");
  return sketch;
}

}  // namespace cornerfix::storage
