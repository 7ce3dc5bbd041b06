/// \file  The last answers of a session without what is large, for those who ask what happened.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include <cornerfix/localizer.hpp>

#include "api/json_codec.hpp"

namespace cornerfix::api {

struct PastPose {
  std::string map;
  std::uint64_t revision = 0;
  Pose2 T_map_base_link;
  std::uint64_t epoch = 0;
  bool confirmed = false;
};

/// An answer without its candidate poses.
struct PastAnswer {
  std::uint64_t sequence = 0;
  std::string received;  ///< When its batch was taken, RFC 3339.
  Status status = Status::kCollecting;
  Reason reason = Reason::kNone;
  std::optional<PastPose> pose;  ///< Only when localized.
  double confidence = 0.0;
  StepTimes times;
};

/// Keeps the newest answers. Not synchronised.
class AnswerHistory {
 public:
  static constexpr std::size_t kMaxAnswers = 300;

  void add(const Answer& answer, std::uint64_t sequence, std::string received);

  /// Oldest first.
  [[nodiscard]] const std::deque<PastAnswer>& answers() const { return answers_; }

 private:
  std::deque<PastAnswer> answers_;
};

[[nodiscard]] Json render_history(std::string_view session, const std::deque<PastAnswer>& answers);

}  // namespace cornerfix::api
