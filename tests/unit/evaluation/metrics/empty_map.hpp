/// \file  A map without content; tests need its name only.
#pragma once

#include <memory>

#include <cornerfix/localization_map.hpp>

namespace cornerfix::evaluation {

[[nodiscard]] inline LocalizationMapPtr empty_map() {
  return std::make_shared<const LocalizationMap>("floor", 1, MapContent{});
}

}  // namespace cornerfix::evaluation
