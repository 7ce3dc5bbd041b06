#include "clients/cpp/map_upload.hpp"

#include <utility>

#include "clients/cpp/scan_json.hpp"

namespace cornerfix::client {

namespace {

/// Larger images are packed before they are sent.
constexpr std::size_t kMaxImageBytes = std::size_t{15} << 20U;

/// The same cells as a png, which is a small part of a large pgm. Returns what the map's owner
/// should know about the files as they were.
Result<std::vector<std::string>> pack(MapFiles& files) {
  const auto image = std::as_bytes(std::span(files.image));
  const Result<OccupancyGrid> grid = parse_map(files.yaml, image);
  if (!grid) return Error{grid.error().code, grid.error().message, files.image_path.string()};
  std::vector<std::string> warnings;
  for (auto note : {thinning_note(files.yaml, *grid), threshold_advice(files.yaml, image)}) {
    if (note) warnings.push_back(std::move(*note));
  }
  const std::vector<std::byte> png = encode_grid_png(*grid);
  files.image.assign(reinterpret_cast<const char*>(png.data()), png.size());
  files.yaml = encode_grid_yaml(*grid, "image.png");
  return warnings;
}

MapGrowth growth_from_json(const nlohmann::json& answer) {
  if (!answer.is_object()) return {};  // Nothing was sent.
  return {.accepted = answer.value("accepted", std::size_t{0}),
          .duplicates = answer.value("duplicates", std::size_t{0}),
          .keyframes = answer.value("keyframes", std::size_t{0}),
          .features = answer.value("features", std::size_t{0}),
          .revision = answer.value("revision", std::uint64_t{0})};
}

std::string path_of_map(const std::string& map) { return "/v1/maps/" + percent_encode(map); }

}  // namespace

std::optional<std::string> description_body(const std::string& description,
                                            const evaluation::LogHeader& header,
                                            const std::optional<KnownOfMap>& known) {
  nlohmann::ordered_json body;
  if (known && known->is_occupancy_map) return std::nullopt;
  if (!known || !known->description) body["description"] = description;
  if (!known || !known->lidar) body["lidar"] = lidar_json(header);
  if (body.empty()) return std::nullopt;
  return body.dump();
}

MapUpload::MapUpload(const std::string& map, evaluation::LogHeader header, ServerConnection& server)
    : path_(path_of_map(map)), header_(std::move(header)), server_(server) {}

Result<void> MapUpload::describe(const std::string& description) {
  std::optional<KnownOfMap> known;
  if (!server_.is_printing()) {
    const Result<nlohmann::json> map = server_.call({"GET", path_});
    if (!map && map.error().code != ErrorCode::kNotFound) return map.error();
    if (map)
      known = {!map->value("description", "").empty(),
               !map->value("lidar", nlohmann::json()).is_null(), map->value("floor_map", false)};
  }
  const auto body = description_body(description, header_, known);
  if (!body) return {};
  const Result<nlohmann::json> described = server_.call({"PUT", path_, *body});
  if (!described) return described.error();
  return {};
}

Result<MapGrowth> MapUpload::add(std::span<const evaluation::LogScan> scans, bool without_poses) {
  auto list = nlohmann::ordered_json::array();
  for (const evaluation::LogScan& scan : scans)
    list.push_back(without_poses ? robot_scan_json(header_, scan, true)
                                 : posed_scan_json(header_, scan));
  const nlohmann::ordered_json body = {{"lidar", lidar_json(header_)}, {"scans", std::move(list)}};
  const auto answer = server_.call({"POST", path_ + "/scans", body.dump()});
  if (!answer) return answer.error();
  return growth_from_json(*answer);
}

Result<std::size_t> MapUpload::count_features() {
  const Result<nlohmann::json> map = server_.call({"GET", path_ + "/features"});
  if (!map) return map.error();
  return map->value("features", nlohmann::json::array()).size();
}

Result<ImportedMap> upload_occupancy_map(ServerConnection& server, const std::string& map,
                                         const std::string& yaml_path, MapFiles files) {
  std::vector<std::string> warnings;
  if (files.image.size() > kMaxImageBytes && !server.is_printing()) {
    auto packed = pack(files);
    if (!packed) return packed.error();
    warnings = std::move(*packed);
  }
  HttpRequest request{"PUT", path_of_map(map) + "/grid"};
  request.form = {{"yaml", yaml_path, std::move(files.yaml)},
                  {"image", files.image_path.string(), std::move(files.image)}};
  const Result<nlohmann::json> answer = server.call(request);
  if (!answer) return answer.error();
  if (!answer->is_object()) return ImportedMap{};  // Nothing was sent.
  ImportedMap imported{answer->value("features", std::size_t{0}),
                       answer->value("revision", std::uint64_t{0}),
                       answer->value("warnings", std::vector<std::string>{})};
  imported.warnings.insert(imported.warnings.end(), warnings.begin(), warnings.end());
  return imported;
}

}  // namespace cornerfix::client
