/// \file  Everything that the library offers. Each header can be included alone, too.
#pragma once

#include <cornerfix/answer.hpp>
#include <cornerfix/corners.hpp>
#include <cornerfix/laser_scan.hpp>
#include <cornerfix/localizability.hpp>
#include <cornerfix/localization_map.hpp>
#include <cornerfix/localizer.hpp>
#include <cornerfix/localizer_params.hpp>
#include <cornerfix/map_image.hpp>
#include <cornerfix/map_sketch.hpp>
#include <cornerfix/map_source.hpp>
#include <cornerfix/mapper.hpp>
#include <cornerfix/occupancy_grid.hpp>
#include <cornerfix/pose2.hpp>
#include <cornerfix/result.hpp>
#include <cornerfix/slam.hpp>
