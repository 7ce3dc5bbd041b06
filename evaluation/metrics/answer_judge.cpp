#include "evaluation/metrics/answer_judge.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace cornerfix::evaluation {

namespace {

double nees_of(const LocalizedPose& pose, const Pose2& reference) {
  const Eigen::Map<const Eigen::Matrix3d> covariance(pose.covariance.data());
  const Pose2& at = pose.T_map_base_link;
  const Eigen::Vector3d error{at.x - reference.x, at.y - reference.y,
                              wrap_angle(at.yaw - reference.yaw)};
  return error.dot(covariance.ldlt().solve(error));
}

}  // namespace

void AnswerJudge::take(const Answer& answer, const Pose2& reference, bool exact,
                       double distance_traveled_m) {
  note_driven(distance_traveled_m);
  if (answer.status != Status::kLocalized) {
    judge_pending();
    note_driven(distance_traveled_m);
    wrong_since_m_.reset();
    localized_ = false;
    return;
  }
  const Pending now{*answer.pose, answer.confidence, reference, distance_traveled_m};
  if (!localized_at_m_) localized_at_m_ = distance_traveled_m;
  if (!localized_) pending_ = now;
  localized_ = true;
  if (!exact) return;
  pending_.reset();
  judge(now, kCorrectAngle);
}

void AnswerJudge::finish() { judge_pending(); }

Withdrawal AnswerJudge::withdrawal() const {
  if (longest_wrong_m_ > kWithdrawalDistance) return Withdrawal::kLate;
  return is_wrong_now() ? Withdrawal::kUndecided : Withdrawal::kInTime;
}

void AnswerJudge::judge(const Pending& answer, double max_angle) {
  const Pose2& pose = answer.pose.T_map_base_link;
  const PoseError error = pose_error(pose, answer.reference);
  const bool in_right_map = right_map_ != nullptr && answer.pose.map == right_map_;
  const JudgedAnswer judged{.pose = pose,
                            .reference = answer.reference,
                            .error = error,
                            .correct = in_right_map && is_correct(error, max_angle),
                            .confidence = answer.confidence,
                            .nees = nees_of(answer.pose, answer.reference),
                            .distance_traveled_m = answer.distance_traveled_m};
  ++judged_;
  forecasts_.push_back({judged.confidence, judged.correct});
  if (first_) {
    nees_after_first_.push_back(judged.nees);
  } else {
    first_ = judged;
  }
  if (judged.correct) {
    wrong_since_m_.reset();
  } else {
    ++wrong_;
    if (!first_wrong_) first_wrong_ = judged;
    if (!wrong_since_m_) wrong_since_m_ = judged.distance_traveled_m;
  }
}

void AnswerJudge::judge_pending() {
  if (!pending_) return;
  judge(*pending_, kCorrectAngleBetweenKeyframes);
  pending_.reset();
}

void AnswerJudge::note_driven(double distance_traveled_m) {
  if (wrong_since_m_)
    longest_wrong_m_ = std::max(longest_wrong_m_, distance_traveled_m - *wrong_since_m_);
}

}  // namespace cornerfix::evaluation
