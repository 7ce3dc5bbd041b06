/// \file  The part of a map's entry that is made of its source.
#pragma once

#include <vector>

#include <cornerfix/mapper.hpp>
#include <cornerfix/result.hpp>

#include "storage/map_store.hpp"

namespace cornerfix::server {

/// A mapper that holds these keyframes, or why its grid could not. O(keyframes * beams).
[[nodiscard]] Result<Mapper> mapper_of(std::vector<PosedScan> key_frames,
                                       const MapperParams& params);

[[nodiscard]] storage::MapOutline outline_of(const Mapper& mapper);
/// Of a map made from an occupancy map: its bounds are the box around the grid, however it is
/// turned.
[[nodiscard]] storage::MapOutline outline_of(const MapContent& content);
/// Of what an archive's map is made of; kInvalidArgument when it cannot be made.
[[nodiscard]] Result<storage::MapOutline> outline_of(const storage::MapArchive& archive);

}  // namespace cornerfix::server
