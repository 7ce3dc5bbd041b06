#include "evaluation/metrics/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "evaluation/metrics/degrees.hpp"
#include "evaluation/metrics/pose_error.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr int kPanelPixels = 480;
constexpr double kPanelMetres = 24.0;
constexpr Rgb kUnknownColor{205, 205, 205};
constexpr Rgb kFreeColor{255, 255, 255};
constexpr Rgb kWallColor{0, 0, 0};
constexpr Rgb kHitColor{220, 30, 30};
constexpr Rgb kRobotColor{30, 60, 220};

/// The robot, and one that accepts nothing beside it.
class ExplainedRobot {
 public:
  ExplainedRobot(const std::vector<LocalizationMapPtr>& maps, LocalizerParams params,
                 std::size_t start, std::optional<Decision>& decision)
      : robot_(maps, params),
        searcher_(maps, never_accepting(params)),
        next_scan_(start),
        decision_(decision) {}

  Answer process(const RobotScan& scan) {
    Answer answer = robot_.process(scan);
    const std::size_t index = next_scan_++;
    if (is_decided_) return answer;
    const Answer search = searcher_.process(scan);
    is_decided_ = answer.status == Status::kLocalized;
    if (search.searched || is_decided_) {
      decision_ = Decision{.scan = index,
                           .answer = answer,
                           .poses = search.hypotheses,
                           .submap = searcher_.state().submap,
                           .T_submap_base_link = search.T_submap_base_link,
                           .reference = {}};
    }
    return answer;
  }

 private:
  static LocalizerParams never_accepting(LocalizerParams params) {
    params.acceptance.min_gap = std::numeric_limits<double>::infinity();
    return params;
  }

  Localizer robot_;
  Localizer searcher_;
  std::size_t next_scan_;
  bool is_decided_ = false;
  std::optional<Decision>& decision_;
};

/// The scans from `start` to the end of its run.
std::vector<std::size_t> run_from(std::span<const std::size_t> asking, std::size_t start) {
  const auto begin = std::ranges::find(asking, start);
  const auto end = std::adjacent_find(begin, asking.end(),
                                      [](std::size_t a, std::size_t b) { return b != a + 1; });
  return {begin, end == asking.end() ? end : end + 1};
}

nlohmann::ordered_json classes_json(const std::vector<EvidenceClass>& classes) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const EvidenceClass& one : classes)
    json[one.name] = {{"count", one.count}, {"decision_llr", one.decision_llr}};
  return json;
}

nlohmann::ordered_json pose_values(const Pose2& pose) { return {pose.x, pose.y, pose.yaw}; }

nlohmann::ordered_json pose_json(const RankedHypothesis& pose, const Pose2& reference,
                                 const LocalizationMap* right_map) {
  const PoseError error = pose_error(pose.T_map_base_link, reference);
  const bool in_right_map = pose.map.get() == right_map;
  const EvidenceScore& score = pose.evidence;
  return {{"map", pose.map->name()},
          {"pose", pose_values(pose.T_map_base_link)},
          {"correct", in_right_map && is_correct(error)},
          {"err", {error.m, error.rad * kDegreesPerRadian}},
          {"hits", score.ends},
          {"matched", score.matched},
          {"contradicted", score.contradicted},
          {"unmapped", score.unmapped},
          {"search_llr", score.fit},
          {"decision_llr", score.log_likelihood},
          {"hits_by_class", classes_json(hits_by_class(score))},
          {"misses_by_class", classes_json(misses_by_class(score))}};
}

nlohmann::ordered_json decision_json(const Decision& decision, const LocalizationMap* right_map) {
  nlohmann::ordered_json json{{"scan", decision.scan},
                              {"status", to_string(decision.answer.status)},
                              {"reason", to_string(decision.answer.reason)},
                              {"confidence", decision.answer.confidence},
                              {"submap_scans", decision.submap.size()},
                              {"reference", pose_values(decision.reference)},
                              {"poses", nlohmann::ordered_json::array()}};
  for (const RankedHypothesis& pose : decision.poses)
    json["poses"].push_back(pose_json(pose, decision.reference, right_map));
  if (decision.poses.size() < 2) return json;
  const double margin =
      decision.poses[0].evidence.log_likelihood - decision.poses[1].evidence.log_likelihood;
  json["margin"] = margin;
  json["margin_per_hit"] = margin / std::max(1, decision.poses[0].evidence.ends);
  return json;
}

/// One panel: a map and the scans laid on it at a pose of the robot.
class Panel {
 public:
  Panel(PngImage& image, int left, const Pose2& T_map_base_link)
      : image_(image), left_(left), T_map_base_link_(T_map_base_link) {}

  void draw_map(const LocalizationMap& map) {
    const OccupancyGrid& grid = map.grid();
    const Pose2 T_grid_map = inverse(grid.T_map_grid);
    for (int y = 0; y < kPanelPixels; ++y) {
      for (int x = 0; x < kPanelPixels; ++x) {
        const Cell cell = grid.at(grid.cell_of(T_grid_map * point_at(x, y)));
        if (cell == Cell::kUnknown) continue;
        image_.set(left_ + x, y, cell == Cell::kFree ? kFreeColor : kWallColor);
      }
    }
  }

  void draw_scans(const Decision& decision) {
    const Pose2 T_map_submap = T_map_base_link_ * inverse(decision.T_submap_base_link);
    for (const SubmapScanPtr& shared : decision.submap) {
      const SubmapScan& kept = *shared;
      const Pose2 T_map_laser = T_map_submap * kept.T_submap_base_link * kept.T_base_link_laser;
      for (std::size_t beam = 0; beam < kept.scan.ranges.size(); ++beam) {
        if (!kept.scan.has_return(beam)) continue;
        const double range = static_cast<double>(kept.scan.ranges[beam]);
        const double bearing = kept.scan.bearing(beam);
        dot(T_map_laser * Point2(range * std::cos(bearing), range * std::sin(bearing)), 0,
            kHitColor);
      }
    }
    dot(T_map_base_link_.translation(), 4, kRobotColor);
    for (int i = 1; i <= 10; ++i) dot(T_map_base_link_ * Point2(0.1 * i, 0.0), 1, kRobotColor);
  }

 private:
  static constexpr double kMetresPerPixel = kPanelMetres / kPanelPixels;

  [[nodiscard]] Point2 point_at(int x, int y) const {
    return T_map_base_link_.translation() +
           kMetresPerPixel * Point2{x - 0.5 * kPanelPixels, 0.5 * kPanelPixels - y};
  }

  void dot(const Point2& point_map, int radius, Rgb color) {
    const Point2 offset = (point_map - T_map_base_link_.translation()) / kMetresPerPixel;
    const int x = static_cast<int>(std::lround(offset.x() + 0.5 * kPanelPixels));
    const int y = static_cast<int>(std::lround(0.5 * kPanelPixels - offset.y()));
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; ++dx) {
        const bool is_in_panel = x + dx >= 0 && x + dx < kPanelPixels;
        if (is_in_panel) image_.set(left_ + x + dx, y + dy, color);
      }
    }
  }

  PngImage& image_;
  int left_;
  Pose2 T_map_base_link_;
};

}  // namespace

Explanation explain(const RecordedLog& log, std::span<const std::size_t> asking, std::size_t start,
                    const std::vector<LocalizationMapPtr>& maps, std::size_t right_map,
                    const std::vector<Point2>& mapping_positions,
                    const EvaluationOptions& options) {
  Explanation explanation;
  EvaluationOptions one = options;
  one.starts = 1;
  one.threads = 1;
  one.make_robot = [&](const LogScan&) -> ScoredRobot {
    const auto robot =
        std::make_shared<ExplainedRobot>(maps, options.localizer, start, explanation.decision);
    return [robot](const RobotScan& scan) { return robot->process(scan); };
  };
  const std::vector<std::size_t> run = run_from(asking, start);
  explanation.record = evaluate(log, run, maps, right_map, mapping_positions, one, nullptr).front();
  if (explanation.decision)
    explanation.decision->reference = *log.scans[explanation.decision->scan].T_map_laser;
  return explanation;
}

nlohmann::ordered_json explanation_json(const Explanation& explanation,
                                        const LocalizationMap* right_map) {
  const StartRecord& record = explanation.record;
  nlohmann::ordered_json json{{"start", record.start},
                              {"near", record.near_m},
                              {"way", nullptr},
                              {"answers_judged", record.answers_judged},
                              {"wrong_answers", record.wrong_answers},
                              {"decision", nullptr}};
  if (record.localized_after_m) json["way"] = *record.localized_after_m;
  if (explanation.decision) json["decision"] = decision_json(*explanation.decision, right_map);
  return json;
}

PngImage draw_decision(const Decision& decision, const LocalizationMap* right_map) {
  std::vector<std::pair<const LocalizationMap*, Pose2>> panels;
  for (std::size_t i = 0; i < std::min<std::size_t>(2, decision.poses.size()); ++i)
    panels.emplace_back(decision.poses[i].map.get(), decision.poses[i].T_map_base_link);
  if (right_map != nullptr) panels.emplace_back(right_map, decision.reference);
  PngImage image(kPanelPixels * static_cast<int>(std::max<std::size_t>(1, panels.size())),
                 kPanelPixels, kUnknownColor);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    Panel panel(image, kPanelPixels * static_cast<int>(i), panels[i].second);
    panel.draw_map(*panels[i].first);
    panel.draw_scans(decision);
  }
  return image;
}

}  // namespace cornerfix::evaluation
