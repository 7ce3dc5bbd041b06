#include "api/answer_history.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace cornerfix::api {
namespace {

Json past_pose_json(const std::optional<PastPose>& pose) {
  if (!pose) return nullptr;
  return {{"map", pose->map},
          {"revision", pose->revision},
          {"x", pose->T_map_base_link.x},
          {"y", pose->T_map_base_link.y},
          {"yaw", pose->T_map_base_link.yaw},
          {"epoch", pose->epoch},
          {"confirmed", pose->confirmed}};
}

Json past_answer_json(const PastAnswer& answer) {
  const bool has_reason = answer.reason != Reason::kNone;
  return {{"sequence", answer.sequence},
          {"received", answer.received},
          {"status", to_string(answer.status)},
          {"reason", has_reason ? Json(to_string(answer.reason)) : Json(nullptr)},
          {"pose", past_pose_json(answer.pose)},
          {"confidence", answer.confidence},
          {"timing_ms", render_times(answer.times)}};
}

}  // namespace

void AnswerHistory::add(const Answer& answer, std::uint64_t sequence, std::string received) {
  PastAnswer past{.sequence = sequence,
                  .received = std::move(received),
                  .status = answer.status,
                  .reason = answer.reason,
                  .pose = std::nullopt,
                  .confidence = answer.confidence,
                  .times = answer.times};
  if (answer.status == Status::kLocalized && answer.pose) {
    past.pose = PastPose{.map = std::string(answer.pose->map->name()),
                         .revision = answer.pose->map->revision(),
                         .T_map_base_link = answer.pose->T_map_base_link,
                         .epoch = answer.pose->epoch,
                         .confirmed = answer.pose->confirmed};
  }
  if (answers_.size() == kMaxAnswers) answers_.pop_front();
  answers_.push_back(std::move(past));
}

Json render_history(std::string_view session, const std::deque<PastAnswer>& answers) {
  Json list = Json::array();
  for (const PastAnswer& answer : answers) list.push_back(past_answer_json(answer));
  return {{"session", session}, {"answers", std::move(list)}};
}

}  // namespace cornerfix::api
