/// \file  Section 4.5, figure 12, tables 4-5: robots switched on all over a building, each method
/// on the same starts, scans, odometry and mapping run, on one thread.
#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "bench/experiments/buildings.hpp"
#include "bench/experiments/csv_file.hpp"
#include "bench/experiments/experiment.hpp"
#include "evaluation/metrics/percentile.hpp"
#include "evaluation/metrics/processor_time.hpp"

namespace cornerfix::bench {
namespace {

using evaluation::mean;
using evaluation::percentile;
using evaluation::thread_ms;

struct RobotsArguments {
  BuildingSource building;
  std::vector<std::string> methods = contestant_names();
  std::size_t starts = 50;
  double near_m = 1.0;           ///< Starts farther from every mapping pose are left out.
  double max_distance_m = 20.0;  ///< Driving allowed until localized.
  double max_time_s = 180.0;     ///< The paper's limit, for driving and for computing.
  std::filesystem::path out = ".";
};

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// The robot, which gives no more answers once its search has taken longer than allowed. The scan
/// in which the time ran out counts.
evaluation::ScoredRobot in_time(evaluation::ScoredRobot robot, const ScanTimes& times,
                                double allowed_s) {
  return [robot = std::move(robot), &times, allowed_s, counted = times.searching_ms.size(),
          spent_ms = 0.0](const RobotScan& scan) mutable {
    if (spent_ms > 1e3 * allowed_s) return Answer{};
    Answer answer = robot(scan);
    for (; counted < times.searching_ms.size(); ++counted) spent_ms += times.searching_ms[counted];
    return answer;
  };
}

const char* verdict_name(evaluation::Verdict verdict) {
  switch (verdict) {
    case evaluation::Verdict::kCorrect:
      return "fixed";
    case evaluation::Verdict::kWrong:
      return "wrong";
    case evaluation::Verdict::kNone:
      break;
  }
  return "none";
}

class RobotsExperiment {
 public:
  explicit RobotsExperiment(const RobotsArguments& arguments)
      : arguments_(arguments),
        building_(open_building(arguments.building)),
        starts_(file("starts"),
                "building,method,start,verdict,way_m,seconds,error_m,error_rad,x_m,y_m,yaw_rad,"
                "true_x_m,true_y_m,true_yaw_rad,searching_ms"),
        times_(file("times"),
               "building,method,phase,scans,mean_ms,p50_ms,p95_ms,max_ms,map_bytes,robot_bytes") {}

  void run() {
    write_way();
    for (const std::string& method : arguments_.methods) run(method);
  }

 private:
  [[nodiscard]] std::filesystem::path file(const std::string& kind) const {
    return arguments_.out / (kind + "_" + arguments_.building.name + ".csv");
  }

  [[nodiscard]] evaluation::EvaluationOptions options() const {
    evaluation::EvaluationOptions options;
    options.starts = arguments_.starts;
    options.near_m = arguments_.near_m;
    options.max_distance_m = arguments_.max_distance_m;
    options.max_time_s = arguments_.max_time_s;
    options.batch = 1;
    return options;
  }

  void run(const std::string& method) {
    const double begin_ms = thread_ms();
    const Contestant contestant = make_contestant(method, building_.mapped);
    ScanTimes times;
    std::vector<double> searching_of_robot;  // sums before each robot, in the order of starts
    evaluation::EvaluationOptions options = this->options();
    options.make_robot = [&](const evaluation::LogScan& first) {
      searching_of_robot.push_back(sum(times.searching_ms));
      return in_time(contestant.switch_on(first, times), times, arguments_.max_time_s);
    };
    const auto records =
        evaluation::evaluate(building_.log, building_.begin, {building_.mapped.map}, 0,
                             building_.mapping_positions, options, nullptr);
    searching_of_robot.push_back(sum(times.searching_ms));
    std::size_t counted = 0;
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (!counts(records[i])) continue;
      ++counted;
      write_start(method, records[i], searching_of_robot[i + 1] - searching_of_robot[i]);
    }
    write_times(method, "searching", times.searching_ms, contestant, times);
    write_times(method, "tracking", times.tracking_ms, contestant, times);
    std::printf("%s %s: %zu of %zu starts in mapped places, %.0f s\n",
                building_.mapped.name.c_str(), method.c_str(), counted, records.size(),
                1e-3 * (thread_ms() - begin_ms));
    std::fflush(stdout);
  }

  [[nodiscard]] bool counts(const evaluation::StartRecord& record) const {
    return record.counts && record.near_m <= arguments_.near_m;
  }

  void write_start(const std::string& method, const evaluation::StartRecord& record,
                   double searching_ms) {
    const bool answered = record.verdict != evaluation::Verdict::kNone;
    const auto if_answered = [answered](double value) {
      return answered ? std::to_string(value) : std::string();
    };
    starts_.row(building_.mapped.name, method, record.start, verdict_name(record.verdict),
                if_answered(record.localized_after_m.value_or(0.0)),
                if_answered(record.localized_after_s.value_or(0.0)), if_answered(record.error_m),
                if_answered(record.error_rad), if_answered(record.pose.x),
                if_answered(record.pose.y), if_answered(record.pose.yaw),
                if_answered(record.truth.x), if_answered(record.truth.y),
                if_answered(record.truth.yaw), searching_ms);
  }

  void write_times(const std::string& method, const char* phase, const std::vector<double>& ms,
                   const Contestant& contestant, const ScanTimes& times) {
    if (ms.empty()) return;
    times_.row(building_.mapped.name, method, phase, ms.size(), mean(ms), percentile(ms, 0.5),
               percentile(ms, 0.95), percentile(ms, 1.0), contestant.map_bytes, times.robot_bytes);
  }

  /// The path that asks, and the walls as the map has them, for figures.
  void write_way() {
    CsvFile path(file("way"), "scan,x_m,y_m");
    for (std::size_t i = building_.begin; i < building_.log.scans.size(); i += 5) {
      const auto& pose = building_.log.scans[i].T_map_laser;
      if (pose) path.row(i, pose->x, pose->y);
    }
    CsvFile walls(file("walls"), "x_m,y_m");
    const OccupancyGrid& grid = building_.mapped.map->grid();
    for (int row = 0; row < grid.height; row += 2) {
      for (int column = 0; column < grid.width; column += 2) {
        if (grid.at({column, row}) != Cell::kOccupied) continue;
        const Point2 point = grid.T_map_grid * grid.center({column, row});
        walls.row(point.x(), point.y());
      }
    }
  }

  RobotsArguments arguments_;
  Building building_;
  CsvFile starts_;
  CsvFile times_;
};

}  // namespace

void add_robots_experiment(CLI::App& app) {
  auto arguments = std::make_shared<RobotsArguments>();
  CLI::App* command = app.add_subcommand(
      "robots", "Section 4.5: robots switched on all over a building, by every method");
  add_building_options(*command, arguments->building);
  command->add_option("--methods", arguments->methods, "Which ones")
      ->delimiter(',')
      ->check(CLI::IsMember(contestant_names()));
  command->add_option("--starts", arguments->starts, "Robots switched on along the run")
      ->check(CLI::PositiveNumber);
  command->add_option("--near", arguments->near_m,
                      "Metres from a mapping pose that a start may be");
  command->add_option("--way", arguments->max_distance_m,
                      "Metres of driving allowed until localized");
  command->add_option("--time", arguments->max_time_s,
                      "Seconds allowed until localized, of driving and of computing");
  add_out_option(*command, arguments->out);
  command->callback([arguments] { RobotsExperiment(*arguments).run(); });
}

}  // namespace cornerfix::bench
