/// \file  The offices of the tests, their map, and what a robot has seen of them at the end of a
/// path.
#pragma once

#include <cornerfix/localization_map.hpp>

#include "support/floor_plans.hpp"
#include "support/map_maker.hpp"
#include "support/seen_view.hpp"

namespace cornerfix::search_tests {

inline const Pose2 kPath[] = {{1.0, 1.0, 0.0}, {2.0, 1.0, 0.5}, {2.0, 2.5, 1.5}, {2.2, 4.5, 1.4}};
inline const Pose2 kTruth = kPath[3];

inline const LocalizationMapPtr& office_map() {
  static const LocalizationMapPtr map = testing::make_map(testing::offices(), {1.0, 1.0});
  return map;
}

inline const View& office_view() {
  static const View view = testing::view_along(testing::offices(), kPath);
  return view;
}

}  // namespace cornerfix::search_tests
