#include "core/src/map/map_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <utility>

namespace cornerfix {

namespace {

Error no_map_yaml(std::string message) {
  return {ErrorCode::kMalformed, std::move(message), "yaml"};
}

Error wrong_key(std::string message, std::string key) {
  return {ErrorCode::kInvalidArgument, std::move(message), std::move(key)};
}

/// A finite number, or `fallback` where the key is missing.
Result<double> number(const YAML::Node& node, const char* key, std::optional<double> fallback) {
  if (!node) {
    if (fallback) return *fallback;
    return wrong_key("missing, expected a number", key);
  }
  double value = 0.0;
  if (!YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
    return wrong_key("expected a finite number", key);
  }
  return value;
}

Result<Pose2> parse_origin(const YAML::Node& node) {
  constexpr const char* kExpected = "expected [x, y, yaw] in metres and radians";
  if (!node || !node.IsSequence() || node.size() != 3) return wrong_key(kExpected, "origin");
  std::array<double, 3> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Result<double> value = number(node[i], "origin", std::nullopt);
    if (!value) return wrong_key(kExpected, "origin");
    values[i] = *value;
  }
  if (std::max(std::abs(values[0]), std::abs(values[1])) > kFarthestOrigin)
    return wrong_key("expected x and y within 1e8 m", "origin");
  return Pose2{values[0], values[1], wrap_angle(values[2])};
}

Result<MapYaml::Mode> parse_mode(const YAML::Node& node) {
  if (!node || node.IsNull()) return MapYaml::Mode::kTrinary;
  std::string name = node.IsScalar() ? node.Scalar() : std::string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  if (name == "trinary") return MapYaml::Mode::kTrinary;
  if (name == "scale") return MapYaml::Mode::kScale;
  if (name == "raw") return MapYaml::Mode::kRaw;
  return wrong_key("expected trinary, scale or raw", "mode");
}

/// 0 and 1 as map_server takes them, or a truth value of YAML (True, yes, off, ...) as nav2 does.
Result<bool> parse_negate(const YAML::Node& node) {
  if (!node) return false;
  const std::string text = node.IsScalar() ? node.Scalar() : std::string();
  if (text == "0" || text == "1") return text == "1";
  bool value = false;
  if (YAML::convert<bool>::decode(node, value)) return value;
  return wrong_key("expected 0 or 1, true or false", "negate");
}

Result<MapYaml> map_yaml_of(const YAML::Node& root) {
  if (!root.IsMap()) return no_map_yaml("expected the keys of a map_server yaml");
  MapYaml out;
  if (!root["image"] || !root["image"].IsScalar() || root["image"].Scalar().empty()) {
    return wrong_key("missing, expected the name of a pgm, png or bmp file", "image");
  }
  out.image = root["image"].Scalar();

  const Result<double> resolution = number(root["resolution"], "resolution", std::nullopt);
  if (!resolution) return resolution.error();
  if (*resolution < kFinestCell || *resolution > kCoarsestCell)
    return wrong_key("expected metres a cell from 0.001 to 100", "resolution");
  out.resolution = *resolution;

  const Result<Pose2> origin = parse_origin(root["origin"]);
  if (!origin) return origin.error();
  out.origin = *origin;

  const Result<bool> negate = parse_negate(root["negate"]);
  if (!negate) return negate.error();
  out.negate = *negate;

  const Result<double> occupied =
      number(root["occupied_thresh"], "occupied_thresh", kOccupiedThreshold);
  if (!occupied) return occupied.error();
  const Result<double> free = number(root["free_thresh"], "free_thresh", kFreeThreshold);
  if (!free) return free.error();
  if (*occupied < 0.0 || *occupied > 1.0) {
    return wrong_key("expected a share from 0 to 1, not " + root["occupied_thresh"].Scalar(),
                     "occupied_thresh");
  }
  if (*free < 0.0 || *free > *occupied) {
    return wrong_key("expected a share from 0 to occupied_thresh", "free_thresh");
  }
  out.occupied_thresh = *occupied;
  out.free_thresh = *free;

  const Result<MapYaml::Mode> mode = parse_mode(root["mode"]);
  if (!mode) return mode.error();
  out.mode = *mode;
  return out;
}

}  // namespace

Result<MapYaml> parse_map_yaml(std::string_view yaml) {
  try {
    // A file system that crashed may leave zeros at the end.
    const std::size_t end = yaml.find_last_not_of('\0') + 1;
    return map_yaml_of(YAML::Load(std::string(yaml.substr(0, end))));
  } catch (const YAML::Exception& error) {
    return no_map_yaml(error.what());
  }
}

/// Whether a cell is a wall, from how bright its pixel is in [0, 1].
Cell classify(const MapYaml& yaml, double brightness) {
  const double shade = yaml.negate ? 1.0 - brightness : brightness;
  // A raw image holds percentages of occupancy; above 100 is unknown.
  const double occupied =
      yaml.mode == MapYaml::Mode::kRaw ? std::round(shade * 255.0) / 100.0 : 1.0 - shade;
  if (occupied > 1.0) return Cell::kUnknown;
  if (occupied > yaml.occupied_thresh) return Cell::kOccupied;
  if (occupied < yaml.free_thresh) return Cell::kFree;
  return Cell::kUnknown;
}

}  // namespace cornerfix
