/// \file  What following a robot costs from a known start, and that it works: Cornerfix beside AMCL
/// with its adaptive number of particles and with all 20,000, and MRPT.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/experiments/buildings.hpp"
#include "bench/experiments/csv_file.hpp"
#include "bench/experiments/experiment.hpp"
#include "bench/rivals/amcl.hpp"
#include "core/src/search/map_index.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/metrics/pose_error.hpp"
#include "evaluation/metrics/processor_time.hpp"
#ifdef CORNERFIX_BENCH_HAS_EXTERNAL
#include "bench/external/mrpt_localizer.hpp"
#endif

namespace cornerfix::bench {
namespace {

using evaluation::mean;
using evaluation::percentile;
using evaluation::thread_ms;

struct TrackingArguments {
  BuildingSource building;
  std::size_t starts = 5;
  double distance_m = 20.0;  ///< That each robot is followed.
  std::filesystem::path out = ".";
};

/// Answers for scans whose pose was known.
struct Tracked {
  std::vector<double> ms;
  std::size_t right = 0;
  std::size_t wrong = 0;

  void judge(const Pose2& said, const Pose2& truth) {
    ++(evaluation::is_correct(evaluation::pose_error(said, truth)) ? right : wrong);
  }
};

class TrackingExperiment {
 public:
  explicit TrackingExperiment(const TrackingArguments& arguments)
      : arguments_(arguments), building_(open_building(arguments.building)) {
    for (std::size_t i = building_.begin; i < building_.log.scans.size(); ++i) {
      if (building_.log.scans[i].T_map_laser) order_.push_back(i);
    }
  }

  void run() {
    CsvFile table(arguments_.out / ("tracking_" + building_.mapped.name + ".csv"),
                  "building,method,scans,mean_ms,p50_ms,p95_ms,right,wrong");
    const auto write = [&](const char* method, const Tracked& tracked) {
      table.row(building_.mapped.name, method, tracked.ms.size(), mean(tracked.ms),
                percentile(tracked.ms, 0.5), percentile(tracked.ms, 0.95), tracked.right,
                tracked.wrong);
    };
    write("cornerfix", track_by_cornerfix());
    write("amcl", track_by_amcl({}));
    AmclParams all;
    all.min_particles = all.max_particles;
    write("amcl_20000", track_by_amcl(all));
    all.linear_resampling = false;
    write("amcl_20000_binary_search", track_by_amcl(all));
#ifdef CORNERFIX_BENCH_HAS_EXTERNAL
    const auto map = std::make_shared<const MrptMap>(building_.mapped.map->grid());
    write("mrpt", track_by_rival([&](const Pose2& start) {
            return make_mrpt_localizer(map, MrptParams{}, start);
          }));
#endif
  }

 private:
  /// Calls `follow` with each scan of each robot's path; `first` at its start.
  template <typename Follow>
  void drive(const Follow& follow) const {
    for (std::size_t i = 0; i < arguments_.starts; ++i) {
      const std::size_t start = i * order_.size() / arguments_.starts;
      double driven = 0.0;
      for (std::size_t k = start; k < order_.size() && driven <= arguments_.distance_m; ++k) {
        const evaluation::LogScan& scan = building_.log.scans[order_[k]];
        if (k > start) {
          driven += distance(*scan.T_map_laser, *building_.log.scans[order_[k - 1]].T_map_laser);
        }
        follow(scan, k == start);
      }
    }
  }

  /// It has no known start: what it says, and costs, once it has found itself.
  [[nodiscard]] Tracked track_by_cornerfix() const {
    Tracked tracked;
    std::unique_ptr<Localizer> localizer;
    bool found = false;
    drive([&](const evaluation::LogScan& scan, bool first) {
      if (first) {
        localizer =
            std::make_unique<Localizer>(std::vector{building_.mapped.map}, LocalizerParams{});
        found = false;
      }
      const double begin = thread_ms();
      const Answer answer = localizer->process({scan.scan, {}, scan.T_odom_laser});
      if (found) {
        tracked.ms.push_back(thread_ms() - begin);
        if (answer.pose) tracked.judge(answer.pose->T_map_base_link, *scan.T_map_laser);
      }
      found = found || answer.status == Status::kLocalized;
    });
    return tracked;
  }

  [[nodiscard]] Tracked track_by_amcl(const AmclParams& params) const {
    return track_by_rival([&](const Pose2& start) {
      const LocalizationMap& map = *building_.mapped.map;
      auto amcl = std::make_unique<Amcl>(map.grid(), map.index().field, params);
      amcl->set_pose(start);
      return amcl;
    });
  }

  /// `make` takes the pose of the start.
  template <typename Make>
  [[nodiscard]] Tracked track_by_rival(const Make& make) const {
    Tracked tracked;
    std::unique_ptr<Rival> rival;
    drive([&](const evaluation::LogScan& scan, bool first) {
      if (first) rival = make(*scan.T_map_laser);
      const double begin = thread_ms();
      const RivalAnswer answer = rival->process({scan.scan, {}, scan.T_odom_laser});
      if (!answer.updated || first) return;
      tracked.ms.push_back(thread_ms() - begin);
      if (answer.T_map_base_link) tracked.judge(*answer.T_map_base_link, *scan.T_map_laser);
    });
    return tracked;
  }

  TrackingArguments arguments_;
  Building building_;
  std::vector<std::size_t> order_;
};

}  // namespace

void add_tracking_experiment(CLI::App& app) {
  auto arguments = std::make_shared<TrackingArguments>();
  CLI::App* command = app.add_subcommand(
      "tracking", "What following a robot costs, by Cornerfix and by Monte Carlo");
  add_building_options(*command, arguments->building);
  command->add_option("--starts", arguments->starts, "Robots followed")->check(CLI::PositiveNumber);
  command->add_option("--way", arguments->distance_m, "Metres that each is followed");
  add_out_option(*command, arguments->out);
  command->callback([arguments] { TrackingExperiment(*arguments).run(); });
}

}  // namespace cornerfix::bench
