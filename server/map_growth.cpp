// How scans join a map: batch by batch, or a whole run at once.
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/growing_map.hpp"
#include "server/map_library.hpp"
#include "server/map_outline.hpp"
#include "server/mapping_batch.hpp"

namespace cornerfix::server {

using storage::MapInfo;
using storage::MapStore;

namespace {

/// Where each stage of a whole run begins, as a share of the work.
constexpr double kOptimizingBegins = 0.3;
constexpr double kGrowthStoringBegins = 0.95;

Error at_scan(Error error, std::ptrdiff_t index) {
  error.field = "/scans/" + std::to_string(index);
  return error;
}

Error run_given_up() {
  return {ErrorCode::kUnavailable, "the mapping of the run was given up", ""};
}

/// Those that the map does not hold yet.
template <typename Scan>
Result<std::vector<const Scan*>> fresh_scans(StoreAccess& stores, std::int64_t map,
                                             std::span<const Scan> scans) {
  std::vector<double> stamps;
  for (const Scan& scan : scans) stamps.push_back(scan.scan.stamp);
  const auto known =
      stores.with_maps([&](MapStore& maps) { return maps.known_stamps(map, stamps); });
  if (!known) return known.error();
  return new_scans(scans, *known);
}

/// The odometry that goes on where the keyframes end.
LidarOdometry continued(std::optional<LidarOdometry>& odometry, const Mapper& mapper) {
  if (odometry) return std::move(*odometry);
  LidarOdometry resumed;
  resumed.resume(mapper.key_frames());
  return resumed;
}

}  // namespace

/// A map with scans that the store does not have yet.
struct MapLibrary::GrownMap {
  Mapper mapper;
  SeenArea seen;
  LidarOdometry odometry{};
  std::vector<double> new_stamps{};
  std::vector<PosedScan> new_key_frames{};

  template <typename Scan>
  [[nodiscard]] Result<void> add(std::span<const Scan> scans, const std::vector<const Scan*>& fresh,
                                 const MapperParams& params, const WorkProgress& progress) {
    for (const Scan* scan : fresh) {
      const double share =
          static_cast<double>(new_stamps.size()) / static_cast<double>(fresh.size());
      if (progress && !progress("odometry", share * kOptimizingBegins)) return run_given_up();
      new_stamps.push_back(scan->scan.stamp);
      PosedScan posed = posed_by(odometry, *scan);
      if (!mapper.is_key_frame(posed)) continue;
      if (auto error = mapper.reject(posed)) return at_scan(*error, scan - scans.data());
      mapper.add(posed);
      seen.add(posed, params);
      if (auto error = seen.reject(mapper.bounds(), params))
        return at_scan(*error, scan - scans.data());
      new_key_frames.push_back(std::move(posed));
    }
    return {};
  }
};

Result<MapGrowthReport> MapLibrary::grow(std::string_view name, std::span<const PosedScan> scans,
                                         const ExpectedMap& expected) {
  return retrying([&] { return grow_once(name, scans, expected); });
}

Result<MapGrowthReport> MapLibrary::grow(std::string_view name, std::span<const RobotScan> scans,
                                         const ExpectedMap& expected) {
  return retrying([&] { return grow_once(name, scans, expected); });
}

Result<MapGrowthReport> MapLibrary::add_run(std::string_view name, std::span<const PosedScan> scans,
                                            const WorkProgress& progress,
                                            const ExpectedMap& expected) {
  return retrying([&] { return add_run_once(name, scans, progress, expected); });
}

Result<MapGrowthReport> MapLibrary::add_run(std::string_view name, std::span<const RobotScan> scans,
                                            const WorkProgress& progress,
                                            const ExpectedMap& expected) {
  return retrying([&] { return add_run_once(name, scans, progress, expected); });
}

template <typename Scan>
Result<MapGrowthReport> MapLibrary::grow_once(std::string_view name, std::span<const Scan> scans,
                                              const ExpectedMap& expected) {
  auto found = find(name);
  if (!found) return found.error();
  const auto growing = this->growing(found->id);
  const std::lock_guard lock(growing->mutex);
  found = find(name);  // The batch before this one may just have changed it.
  if (!found) return found.error();
  return grow_by(*growing, *found, scans, expected, {});
}

/// Robots that need the map do not wait for the run: its keyframes are read for it alone.
template <typename Scan>
Result<MapGrowthReport> MapLibrary::add_run_once(std::string_view name, std::span<const Scan> scans,
                                                 const WorkProgress& progress,
                                                 const ExpectedMap& expected) {
  const auto found = find(name);
  if (!found) return found.error();
  GrowingMap own(found->id);
  return grow_by(own, *found, scans, expected, progress);
}

template <typename Scan>
Result<MapGrowthReport> MapLibrary::grow_by(GrowingMap& growing, const MapInfo& info,
                                            std::span<const Scan> scans,
                                            const ExpectedMap& expected,
                                            const WorkProgress& progress) {
  constexpr bool kHavePoses = std::is_same_v<Scan, PosedScan>;
  if (auto error = mixed(info, kHavePoses)) return *error;
  if (auto rebuilt = rebuild(growing, info); !rebuilt) return rebuilt.error();
  const auto fresh = fresh_scans(*stores_, info.id, scans);
  if (!fresh) return fresh.error();
  MapGrowthReport report{.accepted = fresh->size(),
                         .duplicates = scans.size() - fresh->size(),
                         .key_frames = info.key_frame_count,
                         .features = info.feature_count,
                         .revision = info.revision};
  if (fresh->empty()) return report;
  if (const auto checked = check_expected(info, expected); !checked) return checked.error();
  if constexpr (!kHavePoses) {
    if (auto error = too_late(*fresh, scans, *growing.mapper)) return *error;
  }
  // From here on what is in memory is ahead of the store, until the store has the growth too.
  GrownMap grown{.mapper = std::move(*growing.mapper), .seen = growing.seen};
  if constexpr (!kHavePoses) grown.odometry = continued(growing.odometry, grown.mapper);
  growing.forget();
  const MapperParams params = mapper_params(info);
  if (auto added = grown.add(scans, *fresh, params, progress); !added) return added.error();
  const auto stored = progress ? store_with_content(grown, info, !kHavePoses, progress)
                               : store_growth(grown, info, !kHavePoses);
  if (!stored) return stored.error();
  growing.mapper = std::move(grown.mapper);
  growing.seen = grown.seen;
  if constexpr (!kHavePoses) growing.odometry = std::move(grown.odometry);
  growing.revision = stored->revision;
  report.key_frames = stored->key_frame_count;
  report.features = stored->feature_count;
  report.revision = stored->revision;
  return report;
}

Result<MapInfo> MapLibrary::store_growth(const GrownMap& grown, const MapInfo& before, bool drifts,
                                         const MapContent* content) {
  MapSketch sketch;
  if (content != nullptr) sketch = sketch_of(content->features, content->grid);
  const storage::MapGrowth growth{.stamps = grown.new_stamps,
                                  .new_key_frames = grown.new_key_frames,
                                  .outline = outline_of(grown.mapper),
                                  .drifts = drifts,
                                  .content = content,
                                  .sketch = content != nullptr ? &sketch : nullptr};
  return stores_->with_maps(
      [&](MapStore& maps) { return maps.grow(before.id, before.revision, growth, now_()); });
}

/// The content is made first, so that a run that is given up has changed nothing. It is stored in
/// one transaction with the scans: a repetition of the run finds nothing left to do.
Result<MapInfo> MapLibrary::store_with_content(const GrownMap& grown, const MapInfo& before,
                                               bool drifts, const WorkProgress& progress) {
  const auto content =
      server::content_of(grown.mapper, mapper_params(before), drifts, [&progress](double share) {
        const double whole = kGrowthStoringBegins - kOptimizingBegins;
        return progress("trajectory", kOptimizingBegins + share * whole);
      });
  if (!content) return content.error();
  if (!progress("storing", kGrowthStoringBegins)) return run_given_up();
  return store_growth(grown, before, drifts, &*content);
}

}  // namespace cornerfix::server
