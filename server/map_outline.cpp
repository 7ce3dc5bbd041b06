#include "server/map_outline.hpp"

#include <utility>

#include <cornerfix/mapper.hpp>

#include "api/requests.hpp"
#include "server/seen_area.hpp"

namespace cornerfix::server {

using storage::MapOutline;

namespace {

Bounds bounds_of(const OccupancyGrid& grid) {
  const Point2 first = grid.T_map_grid.translation();
  Bounds bounds{first, first};
  for (const int column : {0, grid.width}) {
    for (const int row : {0, grid.height}) {
      const Point2 corner = grid.T_map_grid * (grid.resolution * Point2(column, row));
      bounds.extend({corner, corner});
    }
  }
  return bounds;
}

}  // namespace

Result<Mapper> mapper_of(std::vector<PosedScan> key_frames, const MapperParams& params) {
  Mapper mapper(params);
  for (PosedScan& key_frame : key_frames) {
    if (auto error = mapper.reject(key_frame)) return std::move(*error);
    mapper.add(std::move(key_frame));
  }
  return mapper;
}

MapOutline outline_of(const Mapper& mapper) {
  return {.feature_count = mapper.feature_count(), .bounds = mapper.bounds()};
}

MapOutline outline_of(const MapContent& content) {
  return {.feature_count = content.features.size(), .bounds = bounds_of(content.grid)};
}

Result<MapOutline> outline_of(const storage::MapArchive& archive) {
  const MapperParams params = api::mapper_params_from_json(archive.parameters_json);
  if (archive.floor_map) {
    const auto made = map_from_grid(*archive.floor_map, params);
    if (!made) return made.error();
    return outline_of(made->content);
  }
  const auto mapper = mapper_of(archive.key_frames, params);
  if (!mapper) return mapper.error();
  if (auto error = SeenArea(*mapper, params).reject(mapper->bounds(), params)) return *error;
  return outline_of(*mapper);
}

}  // namespace cornerfix::server
