#include "core/src/map/map_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace cornerfix {

namespace {

Error no_map_yaml(std::string message) {
  return {ErrorCode::kMalformed, std::move(message), "yaml"};
}

Error wrong_key(std::string message, std::string key) {
  return {ErrorCode::kInvalidArgument, std::move(message), std::move(key)};
}

/// With what is there instead of what was expected.
Error wrong_value(const std::string& expected, const YAML::Node& node, const char* key) {
  constexpr std::size_t kLongest = 60;
  std::string value = YAML::Dump(node);
  if (value.size() > kLongest) value = value.substr(0, kLongest) + "...";
  return wrong_key(expected + ", not " + value, key);
}

/// A turn, with room for rounding [rad]. A yaw above is one in degrees.
constexpr double kLargestYaw = 6.3;

/// Also for a key without a value.
bool is_missing(const YAML::Node& node) { return !node || node.IsNull(); }

/// A finite number, or `fallback` where the key is missing.
Result<double> number(const YAML::Node& node, const char* key, std::optional<double> fallback) {
  if (is_missing(node)) {
    if (fallback) return *fallback;
    return wrong_key("missing, expected a number", key);
  }
  double value = 0.0;
  if (!YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
    return wrong_value("expected a finite number", node, key);
  }
  return value;
}

Result<Pose2> parse_origin(const YAML::Node& node) {
  constexpr const char* kExpected = "expected [x, y, yaw] in metres and radians";
  if (is_missing(node)) return wrong_key("missing, " + std::string(kExpected), "origin");
  if (!node.IsSequence() || node.size() != 3) return wrong_value(kExpected, node, "origin");
  std::array<double, 3> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Result<double> value = number(node[i], "origin", std::nullopt);
    if (!value) return wrong_value(kExpected, node, "origin");
    values[i] = *value;
  }
  if (std::max(std::abs(values[0]), std::abs(values[1])) > kFarthestOrigin)
    return wrong_value("expected x and y within 1e8 m", node, "origin");
  if (std::abs(values[2]) > kLargestYaw) {
    return wrong_value("expected a yaw in radians, within a turn (are these degrees?)", node,
                       "origin");
  }
  return Pose2{values[0], values[1], wrap_angle(values[2])};
}

Result<MapYaml::Mode> parse_mode(const YAML::Node& node) {
  if (is_missing(node)) return MapYaml::Mode::kTrinary;
  std::string name = node.IsScalar() ? node.Scalar() : std::string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  if (name == "trinary") return MapYaml::Mode::kTrinary;
  if (name == "scale") return MapYaml::Mode::kScale;
  if (name == "raw") return MapYaml::Mode::kRaw;
  return wrong_value("expected trinary, scale or raw", node, "mode");
}

/// 0 and 1 as map_server takes them, or a truth value of YAML (True, yes, off, ...) as nav2 does.
Result<bool> parse_negate(const YAML::Node& node) {
  if (is_missing(node)) return false;
  double number = 0.0;
  if (YAML::convert<double>::decode(node, number) && (number == 0.0 || number == 1.0)) {
    return number == 1.0;
  }
  bool value = false;
  if (YAML::convert<bool>::decode(node, value)) return value;
  return wrong_value("expected 0 or 1, true or false", node, "negate");
}

/// The reader takes the first of two equal keys, and the second may be the right one.
std::optional<Error> find_repeated_key(const YAML::Node& root) {
  std::set<std::string> keys;
  for (const auto& entry : root) {
    const YAML::Node& key = entry.first;
    if (key.IsScalar() && !keys.insert(key.Scalar()).second)
      return wrong_key("there twice, expected once", key.Scalar());
  }
  return std::nullopt;
}

std::vector<std::string> find_unread_keys(const YAML::Node& root) {
  constexpr std::size_t kMostKeys = 10;
  constexpr std::size_t kLongest = 40;
  constexpr std::array<std::string_view, 7> kRead = {
      "image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"};
  std::vector<std::string> keys;
  for (const auto& entry : root) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (std::ranges::find(kRead, key) == kRead.end() && keys.size() < kMostKeys)
      keys.push_back(key.substr(0, kLongest));
  }
  return keys;
}

Result<MapYaml> map_yaml_of(const YAML::Node& root) {
  if (!root.IsMap()) {
    return no_map_yaml(
        "expected the keys of a map_server yaml: image, resolution, origin, negate, "
        "occupied_thresh, free_thresh");
  }
  if (auto error = find_repeated_key(root)) return *error;
  MapYaml out;
  constexpr const char* kExpectedImage = "expected the name of a pgm, png or bmp file";
  if (is_missing(root["image"])) {
    return wrong_key("missing, " + std::string(kExpectedImage), "image");
  }
  if (!root["image"].IsScalar() || root["image"].Scalar().empty()) {
    return wrong_value(kExpectedImage, root["image"], "image");
  }
  out.image = root["image"].Scalar();

  const Result<double> resolution = number(root["resolution"], "resolution", std::nullopt);
  if (!resolution) return resolution.error();
  if (*resolution < kFinestCell || *resolution > kCoarsestCell)
    return wrong_value("expected metres per cell from 0.001 to 100", root["resolution"],
                       "resolution");
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
  if (*occupied < 0.0 || *occupied > 1.0) {
    return wrong_value("expected a share from 0 to 1", root["occupied_thresh"], "occupied_thresh");
  }
  const Result<double> free =
      number(root["free_thresh"], "free_thresh", std::min(kFreeThreshold, *occupied));
  if (!free) return free.error();
  if (*free < 0.0 || *free > *occupied) {
    const YAML::Node& limit = root["occupied_thresh"];
    const std::string written = is_missing(limit) ? "0.65 when not given" : YAML::Dump(limit);
    return wrong_value(
        "expected a share from 0 to occupied_thresh (" + written + ", are the two swapped?)",
        root["free_thresh"], "free_thresh");
  }
  out.occupied_thresh = *occupied;
  out.free_thresh = *free;

  const Result<MapYaml::Mode> mode = parse_mode(root["mode"]);
  if (!mode) return mode.error();
  out.mode = *mode;
  out.unread_keys = find_unread_keys(root);
  return out;
}

}  // namespace

Result<MapYaml> parse_map_yaml(std::string_view yaml) {
  for (const std::string_view image : {"P2", "P5", "\x89PNG", "BM"}) {
    if (yaml.starts_with(image)) {
      return no_map_yaml("is an image, expected the yaml: are the two files swapped?");
    }
  }
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
