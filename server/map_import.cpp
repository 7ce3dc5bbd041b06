// How an occupancy map becomes a map.
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <cornerfix/map_image.hpp>
#include <cornerfix/mapper.hpp>

#include "server/growing_map.hpp"
#include "server/map_library.hpp"
#include "server/map_outline.hpp"
#include "storage/digest.hpp"

namespace cornerfix::server {

using storage::MapInfo;
using storage::MapStore;

namespace {

/// A map_server yaml has less than 1 kB. A parsed one takes 40 times the memory of its text.
constexpr std::size_t kMaxYamlBytes = std::size_t{64} << 10U;

/// Where each stage begins, as a share of the whole work.
constexpr double kWallsBegin = 0.05;
constexpr double kFeaturesBegin = 0.15;
constexpr double kDescriptorsBegin = 0.85;
constexpr double kStoringBegin = 0.90;

/// An error in the files of an occupancy map, as one in the form that they came in. Those that may
/// be read but are wrong are keys of the yaml.
Error at_form(Error error) {
  error.field = (error.code == ErrorCode::kInvalidArgument ? "/yaml/" : "/") + error.field;
  return error;
}

bool is_made_from(const MapInfo& info, const OccupancyGrid& floor_map) {
  return info.has_floor_map &&
         info.digest == storage::map_digest(info.parameters_json, storage::hash_of(floor_map));
}

Error import_given_up() {
  return {ErrorCode::kUnavailable, "the import of the occupancy map was given up", ""};
}

/// Progress of the map's making as progress of the import.
GridMapProgress grid_map_progress(const WorkProgress& progress) {
  if (!progress) return {};
  return [&progress](GridMapStage stage, double share) {
    const auto within = [&](double begin, double end) { return begin + share * (end - begin); };
    switch (stage) {
      case GridMapStage::kWalls:
        return progress("walls", within(kWallsBegin, kFeaturesBegin));
      case GridMapStage::kFeatures:
        return progress("features", within(kFeaturesBegin, kDescriptorsBegin));
      case GridMapStage::kDescriptors:
        return progress("descriptors", within(kDescriptorsBegin, kStoringBegin));
    }
    return true;
  };
}

}  // namespace

Result<FloorMapReport> MapLibrary::put_floor_map(std::string_view name, std::string_view yaml,
                                                 std::span<const std::byte> image,
                                                 const WorkProgress& progress,
                                                 const ExpectedMap& expected) {
  if (progress && !progress("reading", 0.0)) return import_given_up();
  if (yaml.size() > kMaxYamlBytes) {
    return Error{ErrorCode::kTooLarge,
                 "the yaml has " + std::to_string(yaml.size()) + " bytes, expected at most " +
                     std::to_string(kMaxYamlBytes),
                 "/yaml"};
  }
  const auto floor_map = parse_map(yaml, image);
  if (!floor_map) return at_form(floor_map.error());
  auto report = retrying([&] { return put_floor_map_once(name, *floor_map, progress, expected); });
  if (!report) return report;
  for (auto note : {thinning_note(yaml, *floor_map), threshold_advice(yaml, image),
                    unknown_advice(yaml, image), unread_keys(yaml)}) {
    if (note) report->warnings.push_back(std::move(*note));
  }
  return report;
}

Result<FloorMapReport> MapLibrary::put_floor_map_once(std::string_view name,
                                                      const OccupancyGrid& floor_map,
                                                      const WorkProgress& progress,
                                                      const ExpectedMap& expected) {
  auto found = find(name);
  if (!found && found.error().code != ErrorCode::kNotFound) return found.error();
  if (!found) {
    if (const auto checked = check_expected(MapInfo{}, expected); !checked) return checked.error();
    return make_from_floor_map(name, floor_map, MapInfo{}, progress);
  }
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The change before this one may just have come.
  if (!found) return found.error();
  const auto checked = check_expected(*found, expected);
  if (!checked && !is_made_from(*found, floor_map)) return checked.error();
  return make_from_floor_map(name, floor_map, *found, progress);
}

Result<FloorMapReport> MapLibrary::make_from_floor_map(std::string_view name,
                                                       const OccupancyGrid& floor_map,
                                                       const MapInfo& before,
                                                       const WorkProgress& progress) {
  auto made = map_from_grid(floor_map, mapper_params(before), grid_map_progress(progress));
  if (!made) return at_part(made.error());
  if (progress && !progress("storing", kStoringBegin)) return import_given_up();
  const storage::FloorMap stored{
      .grid = floor_map, .known = known(before), .outline = outline_of(made->content)};
  auto info =
      stores_->with_maps([&](MapStore& maps) { return maps.put_floor_map(name, stored, now_()); });
  if (!info) return info.error();
  if (auto kept = store_content(*info, made->content); !kept) return kept.error();
  return FloorMapReport{before.revision == 0, std::move(*info), std::move(made->warnings)};
}

}  // namespace cornerfix::server
