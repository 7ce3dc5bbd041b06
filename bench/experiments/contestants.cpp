#include "bench/experiments/contestants.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <utility>

#include "bench/rivals/amcl.hpp"
#include "bench/rivals/branch_and_bound.hpp"
#include "bench/rivals/correlative_search.hpp"
#include "bench/rivals/published_rma.hpp"
#include "bench/rivals/search_rival.hpp"
#include "core/src/search/map_index.hpp"
#include "evaluation/metrics/processor_time.hpp"
#ifdef CORNERFIX_BENCH_HAS_EXTERNAL
#include "bench/external/mrpt_localizer.hpp"
#endif

namespace cornerfix::bench {
namespace {

using evaluation::thread_ms;

using Search = std::function<ScanSearch(const evaluation::LogScan& first)>;
using MakeRival = std::function<std::unique_ptr<Rival>()>;

constexpr int kPyramidDepth = 7;              // the paper's setting for Cartographer
constexpr double kWindow = 7.0;               // [m] likewise
constexpr double kWindowAngle = 0.5236;       // 30 deg, likewise
constexpr double kMinScore = 0.6;             // Cartographer's for global constraints
constexpr std::size_t kSearchedPoints = 100;  // Cartographer's filter of scans to search for
constexpr double kSearchedSpacing = 0.9;      // [m] likewise

/// A rival's answers in the terms of the score, each scan that it worked on timed.
evaluation::ScoredRobot scored(std::unique_ptr<Rival> rival, const LocalizationMapPtr& map,
                               ScanTimes& times) {
  return [rival = std::shared_ptr<Rival>(std::move(rival)), map, &times,
          found = false](const RobotScan& scan) mutable {
    const double begin = thread_ms();
    const RivalAnswer said = rival->process(scan);
    const double took = thread_ms() - begin;
    if (said.updated) (found ? times.tracking_ms : times.searching_ms).push_back(took);
    times.robot_bytes = std::max(times.robot_bytes, rival->bytes());
    Answer answer;
    if (!said.T_map_base_link) return answer;
    found = true;
    answer.status = Status::kLocalized;
    answer.pose = LocalizedPose{map, *said.T_map_base_link, {}};
    return answer;
  };
}

Contestant cornerfix(const std::string& name, const LocalizationMapPtr& map,
                     const LocalizerParams& params) {
  return {name, map->bytes(), [map, params](const evaluation::LogScan&, ScanTimes& times) {
            auto localizer = std::make_shared<Localizer>(std::vector{map}, params);
            return [localizer, &times, found = false](const RobotScan& scan) mutable {
              const double begin = thread_ms();
              Answer answer = localizer->process(scan);
              (found ? times.tracking_ms : times.searching_ms).push_back(thread_ms() - begin);
              found = found || answer.status == Status::kLocalized;
              return answer;
            };
          }};
}

Contestant rival(const std::string& name, std::size_t map_bytes, const LocalizationMapPtr& map,
                 const MakeRival& make) {
  return {name, map_bytes, [map, make](const evaluation::LogScan&, ScanTimes& times) {
            return scored(make(), map, times);
          }};
}

Contestant by_search(const std::string& name, std::size_t map_bytes, const LocalizationMapPtr& map,
                     const Search& search) {
  return {name, map_bytes, [map, search](const evaluation::LogScan& first, ScanTimes& times) {
            return scored(std::make_unique<SearchRival>(search(first), map->index().field), map,
                          times);
          }};
}

std::size_t field_bytes(const LocalizationMapPtr& map) { return map->index().field.steps().size(); }

Contestant amcl(const std::string& name, const LocalizationMapPtr& map, const AmclParams& params) {
  return rival(name, field_bytes(map) + map->grid().cells.size(), map, [map, params] {
    return std::make_unique<Amcl>(map->grid(), map->index().field, params);
  });
}

std::shared_ptr<const BranchAndBoundMatcher> pyramid(const MappedBuilding& building) {
  return std::make_shared<const BranchAndBoundMatcher>(
      build_probability_grid(building.grid_scans, {}), kPyramidDepth);
}

/// A pose that is known as well as the window is wide; anywhere in it, but always the same for one
/// scan.
Pose2 somewhere_about(const evaluation::LogScan& first) {
  std::mt19937_64 random(static_cast<std::uint64_t>(1e3 * std::abs(first.scan.stamp)));
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  const Pose2& truth = *first.T_map_laser;
  return {truth.x + kWindow * share(random), truth.y + kWindow * share(random),
          wrap_angle(truth.yaw + kWindowAngle * share(random))};
}

ScanSearch search_in(const std::shared_ptr<const BranchAndBoundMatcher>& matcher,
                     const SearchWindow& window) {
  return [matcher, window](std::span<const Point2> ends) -> std::optional<Pose2> {
    const std::vector<Point2> points = thin_adaptively(ends, kSearchedPoints, kSearchedSpacing);
    const auto match = matcher->match(points, window, kMinScore);
    return match ? std::optional(match->T_map_base_link) : std::nullopt;
  };
}

Contestant cartographer_full(const std::string& name, const MappedBuilding& building) {
  const auto matcher = pyramid(building);
  return by_search(name, matcher->bytes(), building.map,
                   [matcher](const evaluation::LogScan&) { return search_in(matcher, {}); });
}

Contestant cartographer_window(const std::string& name, const MappedBuilding& building) {
  const auto matcher = pyramid(building);
  return by_search(name, matcher->bytes(), building.map,
                   [matcher](const evaluation::LogScan& first) {
                     return search_in(matcher, {somewhere_about(first), kWindow, kWindowAngle});
                   });
}

Contestant correlative_icp(const std::string& name, const MappedBuilding& building) {
  const LocalizationMapPtr map = building.map;
  const auto search = std::make_shared<const CorrelativeSearch>(map->grid(), map->index().field);
  return by_search(name, field_bytes(map) + search->bytes(), map,
                   [search](const evaluation::LogScan&) -> ScanSearch {
                     return [search](std::span<const Point2> ends) { return search->find(ends); };
                   });
}

Contestant published_rma(const std::string& name, const MappedBuilding& building) {
  const LocalizationMapPtr map = building.vfp_map;
  return rival(name, map->index().descriptor_index.bytes() + field_bytes(map), map,
               [map] { return std::make_unique<PublishedRma>(map, PublishedRmaParams{}); });
}

/// A judge compares maps by identity, and there is one building only.
Contestant in_building(Contestant contestant, const LocalizationMapPtr& map) {
  contestant.switch_on = [inner = std::move(contestant.switch_on), map](
                             const evaluation::LogScan& first,
                             ScanTimes& times) -> evaluation::ScoredRobot {
    return [robot = inner(first, times), map](const RobotScan& scan) {
      Answer answer = robot(scan);
      if (answer.pose) answer.pose->map = map;
      return answer;
    };
  };
  return contestant;
}

#ifdef CORNERFIX_BENCH_HAS_EXTERNAL
Contestant mrpt(const std::string& name, const MappedBuilding& building) {
  const LocalizationMapPtr map = building.map;
  const auto shared = std::make_shared<const MrptMap>(map->grid());
  return rival(name, shared->bytes(), map,
               [shared] { return make_mrpt_localizer(shared, MrptParams{}); });
}
#endif

using Make = Contestant (*)(const std::string& name, const MappedBuilding& building);

const std::vector<std::pair<std::string, Make>>& makers() {
  static const std::vector<std::pair<std::string, Make>> all = {
      {"cornerfix",
       [](const std::string& name, const MappedBuilding& building) {
         return cornerfix(name, building.map, {});
       }},
      {"cornerfix_rma",
       [](const std::string& name, const MappedBuilding& building) {
         LocalizerParams params;
         params.method = Method::kRma;
         return cornerfix(name, building.map, params);
       }},
      {"rma_published", published_rma},
      {"amcl", [](const std::string& name,
                  const MappedBuilding& building) { return amcl(name, building.map, {}); }},
#ifdef CORNERFIX_BENCH_HAS_EXTERNAL
      {"mrpt", mrpt},
#endif
      {"cartographer_full", cartographer_full},
      {"cartographer_window", cartographer_window},
      {"correlative_icp", correlative_icp},
  };
  return all;
}

LocalizationMapPtr build_map(const std::string& name, const std::vector<PosedScan>& key_frames,
                             CornerExtractor extractor) {
  MapperParams params;
  params.extractor = extractor;
  Mapper mapper(params);
  for (const PosedScan& scan : key_frames) mapper.add(scan);
  return std::make_shared<const LocalizationMap>(name, 1, mapper.build());
}

}  // namespace

MappedBuilding map_building(std::string name, const std::vector<PosedScan>& key_frames,
                            std::vector<PosedScan> grid_scans) {
  MappedBuilding building;
  building.map = build_map(name, key_frames, CornerExtractor::kLineIntersection);
  building.vfp_map = build_map(name, key_frames, CornerExtractor::kVfp);
  building.name = std::move(name);
  building.grid_scans = std::move(grid_scans);
  return building;
}

std::vector<std::string> contestant_names() {
  std::vector<std::string> names;
  for (const auto& [name, make] : makers()) names.push_back(name);
  return names;
}

Contestant make_contestant(const std::string& name, const MappedBuilding& building) {
  const auto maker = std::ranges::find(makers(), name, &std::pair<std::string, Make>::first);
  return in_building(maker->second(name, building), building.map);
}

}  // namespace cornerfix::bench
