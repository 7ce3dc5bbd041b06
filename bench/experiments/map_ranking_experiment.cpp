/// \file  Which of many maps? How often the right map is among the first of a ranking by what a
/// robot saw, and what the ranking costs: the catalog beside a global descriptor.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/map_source.hpp>
#include <cornerfix/mapper.hpp>

#include "bench/experiments/csv_file.hpp"
#include "bench/experiments/experiment.hpp"
#include "core/src/search/corner_pairs.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/metrics/processor_time.hpp"
#include "support/seen_view.hpp"
#include "support/simulated_drive.hpp"
#include "support/storeys.hpp"

namespace cornerfix::bench {
namespace {

using evaluation::percentile;
using evaluation::thread_ms;

struct RankingArguments {
  std::vector<std::size_t> maps = {100, 1000};
  std::size_t starts = 200;
  std::filesystem::path out = ".";
};

/// A histogram of the pairs of corners of a place, as a global descriptor. Compared by the cosine
/// similarity of counts, weighted by how rare a class of pairs is among the maps.
class GlobalDescriptors {
 public:
  void put(MapKey key, const MapSketch& sketch) {
    std::vector<OrientedCorner> corners;
    for (const SketchCorner& corner : sketch.corners)
      corners.push_back({{static_cast<double>(corner.x), static_cast<double>(corner.y)},
                         static_cast<double>(corner.bisector),
                         corner.convex});
    const Histogram histogram = histogram_of(corners);
    for (const auto& [word, count] : histogram) ++maps_with_[word];
    histograms_.emplace(key, histogram);
  }

  [[nodiscard]] std::vector<MapKey> rank(std::span<const Feature> seen) const {
    std::vector<OrientedCorner> corners;
    for (const Feature& corner : seen)
      corners.push_back({corner.position, corner.bisector, corner.convex});
    const Histogram query = histogram_of(corners);
    std::vector<std::pair<double, MapKey>> scores;
    for (const auto& [key, histogram] : histograms_) {
      double product = 0.0;
      double squares = 0.0;
      for (const auto& [word, count] : histogram) {
        const double weight = std::log(static_cast<double>(histograms_.size() + 1) /
                                       static_cast<double>(maps_with_.at(word)));
        squares += count * weight * count * weight;
        const auto seen_count = query.find(word);
        if (seen_count != query.end()) product += count * weight * seen_count->second * weight;
      }
      if (squares > 0.0) scores.emplace_back(-product / std::sqrt(squares), key);
    }
    std::ranges::sort(scores);
    std::vector<MapKey> keys;
    for (const auto& [score, key] : scores) keys.push_back(key);
    return keys;
  }

 private:
  using Histogram = std::map<std::size_t, double>;

  static Histogram histogram_of(const std::vector<OrientedCorner>& corners) {
    Histogram histogram;
    for (const OrientedCorner& first : corners) {
      for (const OrientedCorner& second : corners) {
        const auto pair = corner_pair(first, second);
        constexpr double kReach = 8.0;  // [m]; farther pairs are seldom seen together
        if (pair && pair->distance_m < kReach) ++histogram[key_of(*pair)];
      }
    }
    return histogram;
  }

  std::map<MapKey, Histogram> histograms_;
  std::map<std::size_t, std::size_t> maps_with_;
};

/// Where the right map is in a ranking, from 1 on; 0 when it is not there.
template <typename Ranked, typename KeyOf>
std::size_t place_of(MapKey right, const std::vector<Ranked>& ranked, const KeyOf& key_of_entry) {
  const auto found = std::ranges::find(ranked, right, key_of_entry);
  return found == ranked.end() ? 0 : static_cast<std::size_t>(found - ranked.begin()) + 1;
}

double recall(const std::vector<std::size_t>& places, std::size_t k) {
  const auto within = [k](std::size_t place) { return place >= 1 && place <= k; };
  return static_cast<double>(std::ranges::count_if(places, within)) /
         static_cast<double>(places.size());
}

struct Ranker {
  std::string name;
  std::vector<std::size_t> places;
  std::vector<double> ms;
};

/// What a robot has seen on its first metres in a storey.
View first_view(std::uint64_t seed, std::size_t scans) {
  const testing::Storey storey = testing::random_storey(seed);
  const double yaw = 0.7 * static_cast<double>(seed % 9);
  const std::vector<Pose2> poses = testing::wander(
      storey.scene, {storey.inside.x() + 1.0, storey.inside.y(), wrap_angle(yaw)}, scans);
  return testing::view_along(storey.scene, poses);
}

void run_ranking(const RankingArguments& arguments) {
  CsvFile table(arguments.out / "map_ranking.csv",
                "maps,scans,ranker,starts,recall_1,recall_4,recall_16,p50_ms,p95_ms,rivals_p50");
  MapCatalog catalog;
  GlobalDescriptors descriptors;
  std::size_t features = 0;
  for (const std::size_t count : arguments.maps) {
    const double before = thread_ms();
    const std::size_t had = catalog.size();
    for (std::size_t seed = had; seed < count; ++seed) {
      const auto made = value_or_exit(map_from_grid(testing::random_storey(seed).grid(), {}));
      MapSketch sketch = sketch_of(made.content.features, made.content.grid);
      features += sketch.corners.size();
      descriptors.put(static_cast<MapKey>(seed), sketch);
      catalog.put(static_cast<MapKey>(seed), std::move(sketch));
    }
    std::printf(
        "%zu maps, %.1f features per map, %.2f ms per new map, %zu bytes, %.0f per feature\n",
        count, static_cast<double>(features) / static_cast<double>(count),
        (thread_ms() - before) / static_cast<double>(count - had), catalog.bytes(),
        static_cast<double>(catalog.bytes()) / static_cast<double>(features));
    for (const std::size_t scans : {8, 24}) {
      Ranker by_pairs{"catalog", {}, {}};
      Ranker by_descriptor{"global descriptor", {}, {}};
      std::vector<double> rivals;
      for (std::size_t start = 0; start < arguments.starts; ++start) {
        const std::size_t seed = start * count / arguments.starts;
        const View view = first_view(seed, scans);
        const auto right = static_cast<MapKey>(seed);
        double begin = thread_ms();
        const auto ranked = catalog.rank({view.corners, view.evidence.ends});
        by_pairs.ms.push_back(thread_ms() - begin);
        by_pairs.places.push_back(place_of(right, ranked, &RankedMap::key));
        constexpr double kNear = 0.25;  // [nat]
        rivals.push_back(static_cast<double>(std::ranges::count_if(ranked, [&](const auto& one) {
          return one.mean_weight > ranked.front().mean_weight - kNear;
        })));
        begin = thread_ms();
        const auto keys = descriptors.rank(view.corners);
        by_descriptor.ms.push_back(thread_ms() - begin);
        by_descriptor.places.push_back(place_of(right, keys, std::identity{}));
      }
      for (const Ranker& ranker : {by_pairs, by_descriptor}) {
        table.row(count, scans, ranker.name, arguments.starts, recall(ranker.places, 1),
                  recall(ranker.places, 4), recall(ranker.places, 16), percentile(ranker.ms, 0.5),
                  percentile(ranker.ms, 0.95), percentile(rivals, 0.5));
        std::printf("%zu maps, %zu scans, %s: recall %.3f %.3f %.3f, %.2f ms, p95 %.2f, %g near\n",
                    count, scans, ranker.name.c_str(), recall(ranker.places, 1),
                    recall(ranker.places, 4), recall(ranker.places, 16), percentile(ranker.ms, 0.5),
                    percentile(ranker.ms, 0.95), percentile(rivals, 0.5));
        std::fflush(stdout);
      }
    }
  }
}

}  // namespace

void add_map_ranking_experiment(CLI::App& app) {
  auto arguments = std::make_shared<RankingArguments>();
  CLI::App* command = app.add_subcommand(
      "ranking", "How well the catalog ranks generated maps by what a robot saw");
  command->add_option("--maps", arguments->maps, "Sizes of the catalog, ascending")->delimiter(',');
  command->add_option("--starts", arguments->starts, "Robots switched on, per size")
      ->check(CLI::PositiveNumber);
  add_out_option(*command, arguments->out);
  command->callback([arguments] { run_ranking(*arguments); });
}

}  // namespace cornerfix::bench
