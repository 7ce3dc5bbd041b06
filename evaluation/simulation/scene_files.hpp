/// \file  Writes generated scenes as files of ROS map_server.
#pragma once

#include <filesystem>

#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix::evaluation {

/// Writes `stem`.png and `stem`.yaml; `stem` may name the yaml.
[[nodiscard]] Result<void> write_scene(std::filesystem::path stem, const OccupancyGrid& scene);

}  // namespace cornerfix::evaluation
