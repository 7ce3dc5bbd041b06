/// \file  Judges every `localized` answer of one robot against the reference poses of its log.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <cornerfix/localizer.hpp>

#include "evaluation/metrics/pose_error.hpp"
#include "evaluation/metrics/reliability.hpp"

namespace cornerfix::evaluation {

/// A wrong pose should be withdrawn within this path length. [m]
inline constexpr double kWithdrawalDistance = 3.0;

/// A `localized` answer with its reference. Poses are of base_link in `map`.
struct JudgedAnswer {
  Pose2 pose;
  Pose2 reference;
  PoseError error;
  bool correct = false;
  double confidence = 0.0;
  double nees = 0.0;  ///< Normalised estimation error squared; 3 on average if covariance is right.
  double distance_traveled_m = 0.0;  ///< From the start of the robot.
};

/// What happened to the wrong poses of a robot.
enum class Withdrawal {
  kInTime,     ///< Each was withdrawn or corrected within kWithdrawalDistance.
  kLate,       ///< The robot drove farther than that with a wrong pose.
  kUndecided,  ///< The run ended before the last one was withdrawn or late.
};

/// Judges the answers of one robot in the order in which they were given. A wrong answer counts at
/// any time, not only when the robot is first localized.
///
/// Logs with keyframes carry exact references only there. In such a log an answer is judged at
/// keyframes. A robot that becomes localized between two keyframes is judged at the next keyframe,
/// or with kCorrectAngleBetweenKeyframes where it became localized if it is no longer localized at
/// that keyframe.
class AnswerJudge {
 public:
  /// \param right_map  The map that holds the surroundings; null if none does: every answer is
  /// wrong then.
  explicit AnswerJudge(LocalizationMapPtr right_map) : right_map_(std::move(right_map)) {}

  /// \param reference  Pose of base_link at the answer's last scan.
  /// \param exact      Whether the reference may be compared to kCorrectAngle.
  /// \param distance_traveled_m   Path length so far; never less than at the call before.
  void take(const Answer& answer, const Pose2& reference, bool exact, double distance_traveled_m);

  /// Judges what the end of the run leaves open.
  void finish();

  /// Path length at the first `localized` answer, judged or not.
  [[nodiscard]] const std::optional<double>& localized_at_m() const { return localized_at_m_; }
  /// Whether there is a `localized` answer that is yet to be judged.
  [[nodiscard]] bool is_pending() const { return pending_.has_value(); }
  [[nodiscard]] const std::optional<JudgedAnswer>& first() const { return first_; }
  [[nodiscard]] const std::optional<JudgedAnswer>& first_wrong() const { return first_wrong_; }
  [[nodiscard]] std::size_t judged() const { return judged_; }
  [[nodiscard]] std::size_t wrong() const { return wrong_; }
  /// Of the judged answers after the first.
  [[nodiscard]] const std::vector<double>& nees_after_first() const { return nees_after_first_; }
  /// Confidence of every judged answer.
  [[nodiscard]] const std::vector<Forecast>& forecasts() const { return forecasts_; }
  /// Longest path length from a wrong answer to the first later one that is correct or no longer
  /// `localized`, or to the last answer if there is none.
  [[nodiscard]] double longest_wrong_m() const { return longest_wrong_m_; }
  /// Whether the last judged answer was wrong and still stands.
  [[nodiscard]] bool is_wrong_now() const { return wrong_since_m_.has_value(); }
  /// Meaningful when there is a wrong answer.
  [[nodiscard]] Withdrawal withdrawal() const;

 private:
  struct Pending {
    LocalizedPose pose;
    double confidence = 0.0;
    Pose2 reference;
    double distance_traveled_m = 0.0;
  };

  void judge(const Pending& answer, double max_angle);
  void judge_pending();
  void note_driven(double distance_traveled_m);

  LocalizationMapPtr right_map_;
  bool localized_ = false;          ///< At the last answer.
  std::optional<Pending> pending_;  ///< Since the robot became localized, until it is judged.
  std::optional<double> localized_at_m_;
  std::optional<JudgedAnswer> first_;
  std::optional<JudgedAnswer> first_wrong_;
  std::optional<double> wrong_since_m_;  ///< While a wrong pose stands.
  double longest_wrong_m_ = 0.0;
  std::size_t judged_ = 0;
  std::size_t wrong_ = 0;
  std::vector<double> nees_after_first_;
  std::vector<Forecast> forecasts_;
};

}  // namespace cornerfix::evaluation
