#include <cornerfix/localizer_params.hpp>

#include <cmath>

namespace cornerfix {

std::optional<Error> validate(const StartRegion& region) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!std::isfinite(region.center.x())) return broken("x", "must be finite");
  if (!std::isfinite(region.center.y())) return broken("y", "must be finite");
  if (!(region.radius_m > 0.0 && std::isfinite(region.radius_m)))
    return broken("radius_m", "must be positive");
  if (region.yaw && !std::isfinite(*region.yaw)) return broken("yaw", "must be finite");
  if (!(region.yaw_tolerance_rad > 0.0 && region.yaw_tolerance_rad <= std::numbers::pi))
    return broken("yaw_tolerance_rad", "must be in (0, pi]");
  return std::nullopt;
}

}  // namespace cornerfix
