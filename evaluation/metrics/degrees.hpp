/// \file  Angles as people read them.
#pragma once

#include <numbers>

namespace cornerfix::evaluation {

inline constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

}  // namespace cornerfix::evaluation
