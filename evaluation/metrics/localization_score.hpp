/// \file  Scores the localizer on a recorded run: one part makes the map, from many scans of the
/// rest a robot is switched on. In process and on all cores; the rules and the names of the figures
/// are those of the HTTP replay.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <cornerfix/localizer.hpp>
#include <cornerfix/mapper.hpp>

#include "evaluation/datasets/log_reader.hpp"
#include "evaluation/metrics/answer_judge.hpp"
#include "evaluation/metrics/in_parallel.hpp"
#include "evaluation/metrics/reliability.hpp"
#include "evaluation/simulation/odometry_fault.hpp"

namespace cornerfix::evaluation {

/// Takes a robot's scans one after the other, as Localizer::process() does.
using ScoredRobot = std::function<Answer(const RobotScan&)>;

struct EvaluationOptions {
  std::size_t starts = 100;
  double near_m = 1.5;           ///< A start this near to a mapping pose lies in the mapped part.
  double max_distance_m = 20.0;  ///< Driving allowed until localized.
  double max_time_s = 180.0;     ///< Log time allowed (the paper's limit).
  double track_m = 5.0;          ///< Path length followed after the first `localized` answer.
  std::size_t batch = 5;         ///< Scans per question.
  bool use_odometry = true;
  /// Corrupts the odometry of each robot, by the index of its first scan as seed.
  std::optional<OdometryFaultKind> odometry_fault;
  std::size_t threads = 1;
  bool mirror = false;  ///< Turn the scans over: no pose may be accepted then.
  bool sample = false;  ///< Never accept; record what each search of the whole map knew.
  MapperParams mapper;
  LocalizerParams localizer;
  /// The method that is started: a Localizer when empty. It gets the first scan with its reference
  /// pose, for methods that need an initial pose; called from any thread.
  std::function<ScoredRobot(const LogScan&)> make_robot;
};

enum class Verdict { kCorrect, kWrong, kNone };

/// What was known of the two best poses after a search of the whole map, for calibration.
struct DecisionSample {
  double distance_traveled_m = 0.0;
  double near_m = 0.0;  ///< From the nearest mapping pose, now.
  bool right = false;   ///< Whether the best pose is the true one.
  EvidenceScore best;
  EvidenceScore second;  ///< No hits when there was no other pose.
  AcceptanceTerms terms;
};

/// What happened to one robot.
struct StartRecord {
  std::size_t start = 0;  ///< Index of the first scan in the log.
  bool counts = true;     ///< Enough log lay ahead when the robot was switched on.
  double near_m = 0.0;    ///< From the nearest mapping pose.
  Verdict verdict = Verdict::kNone;
  Reason reason = Reason::kNone;  ///< Of the last answer: why it was not localized, if so.
  double distance_traveled_m = 0.0;
  std::optional<double> localized_after_m;  ///< Path length.
  std::optional<double> localized_after_s;
  double confidence = 0.0;  ///< When localized.
  double error_m = 0.0;     ///< When localized.
  double error_rad = 0.0;
  Pose2 pose;  ///< Of the laser, when localized, as answered and as it was.
  Pose2 truth;
  std::size_t scans = 0;
  std::size_t right_after = 0;  ///< Judged answers after the first one.
  std::size_t wrong_after = 0;
  std::size_t answers_judged = 0;  ///< `localized` answers with a reference, the first included.
  std::size_t wrong_answers = 0;   ///< Of them.
  std::optional<JudgedAnswer> first_wrong;
  double longest_wrong_m = 0.0;                    ///< Longest path length with a wrong pose.
  Withdrawal withdrawal = Withdrawal::kUndecided;  ///< If any was wrong.
  std::vector<double>
      nees;  ///< Of the judged answers after the first: 3 on average if covariance is right.
  std::vector<double> searching_ms;   ///< Processor time per scan, until localized.
  std::vector<double> tracking_ms;    ///< Per scan, after it.
  std::vector<double> round_trip_ms;  ///< Per scan, by the wall clock: what a caller waits.
  std::vector<DecisionSample> samples;
  std::vector<Forecast> searches;   ///< Best pose of each search of the whole map.
  std::vector<Forecast> localized;  ///< Judged `localized` answers.
};

struct Evaluation {
  LocalizationMapPtr map;
  std::vector<Point2> mapping_positions;  ///< Of the laser.
  std::vector<PosedScan> keyframes;       ///< What the map was made of.
  double map_seconds = 0.0;               ///< Processor time.
  std::string split;                      ///< How the log was divided, as given.
  double wall_s = 0.0;                    ///< Of all starts.
  std::vector<StartRecord> records;
};

/// The map of the posed scans before `end`, as a server would make it; no records yet.
[[nodiscard]] Evaluation map_from(const RecordedLog& log, std::size_t end,
                                  const MapperParams& params);
/// The same of the posed scans with these indices.
[[nodiscard]] Evaluation map_from(const RecordedLog& log, std::span<const std::size_t> mapping,
                                  const MapperParams& params, const ShareDone& progress = {});

/// The map of a ROS occupancy map alone; where `log` drives through its free space counts as
/// mapped. Says on stderr what map_from_grid() warns of.
[[nodiscard]] Result<Evaluation> map_from_occupancy_map(const std::filesystem::path& yaml,
                                                        const RecordedLog& log,
                                                        const MapperParams& params);

/// Scans before the split; all of them for a map log.
[[nodiscard]] std::size_t split_index(const RecordedLog& log, double share);

/// Positions in `asking` at which a start counts: the log drives on without a gap for
/// `max_distance_m` or for `max_time_s`. Known before anything is asked, so that no answer can take
/// a start out of the count.
[[nodiscard]] std::vector<std::size_t> countable_starts(const RecordedLog& log,
                                                        std::span<const std::size_t> asking,
                                                        double max_distance_m, double max_time_s);

inline constexpr std::size_t kNoMap =
    static_cast<std::size_t>(-1);  ///< The log lies in none of the maps.

/// Asks `log` from `begin` on in `maps`; any pose in another map than `maps[right_map]` is wrong.
/// Starts are spread evenly over the scans that have enough log ahead. If no scan has, they are
/// spread over all scans and none of the records counts.
/// \param mapping_positions  Where the right map was made from.
[[nodiscard]] std::vector<StartRecord> evaluate(const RecordedLog& log, std::size_t begin,
                                                const std::vector<LocalizationMapPtr>& maps,
                                                std::size_t right_map,
                                                const std::vector<Point2>& mapping_positions,
                                                const EvaluationOptions& options,
                                                const ShareDone& progress);
/// The same of the posed scans with these indices, ascending; a gap between them ends a run.
[[nodiscard]] std::vector<StartRecord> evaluate(const RecordedLog& log,
                                                std::span<const std::size_t> asking,
                                                const std::vector<LocalizationMapPtr>& maps,
                                                std::size_t right_map,
                                                const std::vector<Point2>& mapping_positions,
                                                const EvaluationOptions& options,
                                                const ShareDone& progress);

}  // namespace cornerfix::evaluation
