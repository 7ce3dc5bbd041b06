/// \file  Which map am I in? A robot with a given map, and the same robot among many: all other
/// buildings, their mirror images and parts of them, and the mirror image of its own.
#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/map_image.hpp>
#include <cornerfix/mapper.hpp>

#include "bench/experiments/buildings.hpp"
#include "bench/experiments/csv_file.hpp"
#include "bench/experiments/experiment.hpp"
#include "evaluation/metrics/percentile.hpp"

namespace cornerfix::bench {
namespace {

using evaluation::mean;
using evaluation::percentile;

struct ManyMapsArguments {
  BuildingSource building;
  std::vector<std::string> logs;        ///< Of other buildings.
  std::vector<std::string> floor_maps;  ///< Of other buildings.
  std::size_t maps = 100;
  std::size_t starts = 100;
  std::filesystem::path out = ".";
};

/// A part of a grid, by shares of its width and height.
struct Part {
  double left, right, bottom, top;
};
constexpr Part kWhole{0.0, 1.0, 0.0, 1.0};
constexpr Part kParts[] = {{0.0, 0.5, 0.0, 1.0}, {0.5, 1.0, 0.0, 1.0}, {0.0, 1.0, 0.0, 0.5},
                           {0.0, 1.0, 0.5, 1.0}, {0.0, 0.5, 0.0, 0.5}, {0.5, 1.0, 0.0, 0.5},
                           {0.0, 0.5, 0.5, 1.0}, {0.5, 1.0, 0.5, 1.0}};

OccupancyGrid part_of(const OccupancyGrid& grid, const Part& part, bool mirror) {
  const int left = static_cast<int>(part.left * grid.width);
  const int bottom = static_cast<int>(part.bottom * grid.height);
  OccupancyGrid variant;
  variant.resolution = grid.resolution;
  variant.width = static_cast<int>(part.right * grid.width) - left;
  variant.height = static_cast<int>(part.top * grid.height) - bottom;
  for (int row = 0; row < variant.height; ++row) {
    for (int column = 0; column < variant.width; ++column) {
      const int from = mirror ? variant.width - 1 - column : column;
      variant.cells.push_back(grid.at({left + from, bottom + row}));
    }
  }
  return variant;
}

/// Maps of grids, until there are enough of them.
class MapCollection {
 public:
  MapCollection(LocalizationMapPtr own, std::size_t size) : size_(size) {
    maps_.push_back(std::move(own));
  }

  /// Leaves out what holds too little to be a map.
  void add(const OccupancyGrid& grid) {
    if (maps_.size() == size_) return;
    constexpr std::size_t kLeastFeatures = 20;
    Result<GridMap> map = map_from_grid(grid, {});
    if (!map || map->content.features.size() < kLeastFeatures) return;
    maps_.push_back(std::make_shared<const LocalizationMap>("map " + std::to_string(maps_.size()),
                                                            1, std::move(map->content)));
  }

  [[nodiscard]] const std::vector<LocalizationMapPtr>& maps() const { return maps_; }

 private:
  std::size_t size_;
  std::vector<LocalizationMapPtr> maps_;
};

std::vector<OccupancyGrid> other_buildings(const ManyMapsArguments& arguments) {
  std::vector<OccupancyGrid> grids;
  for (const std::string& path : arguments.logs) {
    const evaluation::RecordedLog log = value_or_exit(evaluation::read_log(path));
    grids.push_back(evaluation::map_from(log, log.scans.size(), {}).map->grid());
  }
  for (const std::string& path : arguments.floor_maps)
    grids.push_back(value_or_exit(read_map_files(path)));
  return grids;
}

/// The right map first.
std::vector<LocalizationMapPtr> maps_about(const Building& building,
                                           const ManyMapsArguments& arguments) {
  MapCollection collection(building.mapped.map, arguments.maps);
  const std::vector<OccupancyGrid> others = other_buildings(arguments);
  collection.add(part_of(building.mapped.map->grid(), kWhole, true));
  for (const bool mirror : {false, true}) {
    for (const OccupancyGrid& grid : others) collection.add(part_of(grid, kWhole, mirror));
  }
  for (const Part& part : kParts) {
    for (const bool mirror : {false, true}) {
      for (const OccupancyGrid& grid : others) collection.add(part_of(grid, part, mirror));
    }
  }
  return collection.maps();
}

void run(const ManyMapsArguments& arguments) {
  const Building building = open_building(arguments.building);
  const std::vector<LocalizationMapPtr> all = maps_about(building, arguments);
  CsvFile table(arguments.out / ("many_maps_" + building.mapped.name + ".csv"),
                "building,maps,starts,right,wrong,way_p50_m,way_p90_m,mean_ms,p50_ms,p95_ms");
  evaluation::EvaluationOptions options;
  options.starts = arguments.starts;
  options.batch = 1;
  options.track_m = 0.0;
  for (const std::vector<LocalizationMapPtr>& maps : {std::vector{all.front()}, all}) {
    int starts = 0;
    int right = 0;
    int wrong = 0;
    std::vector<double> distances_m;
    std::vector<double> ms;
    for (const evaluation::StartRecord& record : evaluation::evaluate(
             building.log, building.begin, maps, 0, building.mapping_positions, options, nullptr)) {
      if (record.near_m > options.near_m || !record.counts) continue;
      ++starts;
      right += record.verdict == evaluation::Verdict::kCorrect ? 1 : 0;
      wrong += record.verdict == evaluation::Verdict::kWrong ? 1 : 0;
      if (record.verdict == evaluation::Verdict::kCorrect)
        distances_m.push_back(record.localized_after_m.value_or(0.0));
      std::ranges::copy(record.searching_ms, std::back_inserter(ms));
    }
    table.row(building.mapped.name, maps.size(), starts, right, wrong, percentile(distances_m, 0.5),
              percentile(distances_m, 0.9), mean(ms), percentile(ms, 0.5), percentile(ms, 0.95));
    std::printf("%s among %zu: %d starts, %d right, %d wrong, %.2f ms a scan\n",
                building.mapped.name.c_str(), maps.size(), starts, right, wrong, mean(ms));
    std::fflush(stdout);
  }
}

}  // namespace

void add_many_maps_experiment(CLI::App& app) {
  auto arguments = std::make_shared<ManyMapsArguments>();
  CLI::App* command =
      app.add_subcommand("maps", "A robot that is given its map, and the same robot among many");
  add_building_options(*command, arguments->building);
  command->add_option("--logs", arguments->logs, "Recorded runs in other buildings")
      ->delimiter(',')
      ->check(CLI::ExistingFile);
  command->add_option("--floor-maps", arguments->floor_maps, "Yamls of other buildings")
      ->delimiter(',')
      ->check(CLI::ExistingFile);
  command->add_option("--maps", arguments->maps, "How many, the right one among them")
      ->check(CLI::PositiveNumber);
  command->add_option("--starts", arguments->starts, "Robots switched on along the run")
      ->check(CLI::PositiveNumber);
  add_out_option(*command, arguments->out);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace cornerfix::bench
