#include "api/start_region_codec.hpp"

#include <nlohmann/json.hpp>

namespace cornerfix::api {
namespace {

constexpr double kLargestRadius = 1e5;   // [m]
constexpr double kUsualTolerance = 0.8;  // of a yaw without yaw_tolerance_rad [rad]

/// Reads a number above zero, up to `most`; `number` stays when the member is wrong or not there.
void read_positive(const JsonField& object, const char* name, double most, double& number) {
  const auto field = object.find(name);
  const auto value = field ? field->as_number(0.0, most) : std::nullopt;
  if (value && *value <= 0.0) field->fail("must be above 0");
  if (value) number = *value;
}

void read_yaw(const JsonField& object, StartRegion& region) {
  const auto yaw = object.find("yaw");
  const auto tolerance = object.find("yaw_tolerance_rad");
  if (!yaw) {
    if (tolerance) tolerance->fail("must not be there without yaw");
    return;
  }
  if (const auto value = yaw->as_number()) region.yaw = wrap_angle(*value);
  region.yaw_tolerance_rad = kUsualTolerance;
  read_positive(object, "yaw_tolerance_rad", std::numbers::pi, region.yaw_tolerance_rad);
}

}  // namespace

std::optional<StartRegion> read_start_region(const JsonField& field) {
  if (!field.expect_object()) return std::nullopt;
  StartRegion region;
  if (const auto map = field.find("map")) region.map = map->as_name().value_or("");
  const auto coordinate = [&](const char* name) {
    const auto member = field.require(name, "metres, in the map");
    const auto value = member ? member->as_number(-kMaxCoordinate, kMaxCoordinate) : std::nullopt;
    return value.value_or(0.0);
  };
  region.center = {coordinate("x"), coordinate("y")};
  if (field.require("radius_m", "metres about x and y"))
    read_positive(field, "radius_m", kLargestRadius, region.radius_m);
  read_yaw(field, region);
  field.expect_members({"map", "x", "y", "radius_m", "yaw", "yaw_tolerance_rad"});
  return validate(region) ? std::nullopt : std::optional(std::move(region));
}

Json render_start_region(const std::optional<StartRegion>& region) {
  if (!region) return nullptr;
  Json json;
  if (!region->map.empty()) json["map"] = region->map;
  json["x"] = region->center.x();
  json["y"] = region->center.y();
  json["radius_m"] = region->radius_m;
  if (region->yaw) {
    json["yaw"] = *region->yaw;
    json["yaw_tolerance_rad"] = region->yaw_tolerance_rad;
  }
  return json;
}

}  // namespace cornerfix::api
