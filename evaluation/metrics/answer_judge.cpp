#include "evaluation/metrics/answer_judge.hpp"

#include <Eigen/Cholesky>

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

void AnswerJudge::take(const Answer& answer, const Pose2& reference, bool exact, double driven_m) {
  driven_m_ = driven_m;
  if (answer.status != Status::kLocalized) {
    judge_pending();
    if (localized_) note_withdrawal(driven_m);
    localized_ = false;
    return;
  }
  const Pending now{*answer.pose, answer.confidence, reference, driven_m};
  if (!localized_at_m_) localized_at_m_ = driven_m;
  if (!localized_) pending_ = now;
  localized_ = true;
  if (!exact) return;
  pending_.reset();
  judge(now, kCorrectAngle);
}

void AnswerJudge::finish() { judge_pending(); }

Withdrawal AnswerJudge::withdrawal() const {
  const double since_m =
      withdrawn_after_m_.value_or(first_wrong_ ? driven_m_ - first_wrong_->driven_m : 0.0);
  if (since_m > kWithdrawalDistance) return Withdrawal::kLate;
  return withdrawn_after_m_ ? Withdrawal::kInTime : Withdrawal::kUndecided;
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
                            .driven_m = answer.driven_m};
  ++judged_;
  if (first_) {
    nees_after_first_.push_back(judged.nees);
  } else {
    first_ = judged;
  }
  if (judged.correct) {
    note_withdrawal(judged.driven_m);
  } else {
    ++wrong_;
    if (!first_wrong_) first_wrong_ = judged;
  }
}

void AnswerJudge::judge_pending() {
  if (!pending_) return;
  judge(*pending_, kCorrectAngleBetweenKeyframes);
  pending_.reset();
}

void AnswerJudge::note_withdrawal(double driven_m) {
  if (first_wrong_ && !withdrawn_after_m_) withdrawn_after_m_ = driven_m - first_wrong_->driven_m;
}

}  // namespace cornerfix::evaluation
