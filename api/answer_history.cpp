#include "api/answer_history.hpp"

#include <cassert>
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

Json recorded_answer_json(const RecordedAnswer& recorded, const std::string& received) {
  Json json =
      with_points(Json::parse(recorded.answer), recorded.last_scan, recorded.features_base_link);
  json["received"] = received;
  return json;
}

Json past_answer_json(const PastAnswer& answer) {
  if (answer.recorded) return recorded_answer_json(*answer.recorded, answer.received);
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
                  .times = answer.times,
                  .recorded = nullptr};
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

void AnswerHistory::record(RecordedAnswer recorded, std::size_t max_recorded) {
  assert(!answers_.empty() && max_recorded > 0);
  answers_.back().recorded = std::make_shared<const RecordedAnswer>(std::move(recorded));
  if (answers_.size() > max_recorded) answers_[answers_.size() - 1 - max_recorded].recorded.reset();
}

Json render_history(std::string_view session, const std::deque<PastAnswer>& answers) {
  Json list = Json::array();
  for (const PastAnswer& answer : answers) list.push_back(past_answer_json(answer));
  return {{"session", session}, {"answers", std::move(list)}};
}

}  // namespace cornerfix::api
