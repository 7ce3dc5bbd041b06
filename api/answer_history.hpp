/// \file  The last answers of a session without what is large, for those who ask what happened.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

/// The answer as it was sent, with what it was made from.
struct RecordedAnswer {
  std::string answer;  ///< Rendered.
  RobotScan last_scan;
  std::vector<Point2> features_base_link;
};

/// An answer without its candidate poses, unless it is recorded.
struct PastAnswer {
  std::uint64_t sequence = 0;
  std::string received;  ///< When its batch was taken, RFC 3339.
  Status status = Status::kCollecting;
  Reason reason = Reason::kNone;
  std::optional<PastPose> pose;  ///< Only when localized.
  double confidence = 0.0;
  StepTimes times;
  std::shared_ptr<const RecordedAnswer> recorded;  ///< Null, mostly: it would be half of this.
};

/// Keeps the newest answers. Not synchronised.
class AnswerHistory {
 public:
  static constexpr std::size_t kMaxAnswers = 300;

  void add(const Answer& answer, std::uint64_t sequence, std::string received);

  /// Keeps the newest answer whole, and of those before only the newest `max_recorded - 1`.
  void record(RecordedAnswer recorded, std::size_t max_recorded);

  /// Oldest first.
  [[nodiscard]] const std::deque<PastAnswer>& answers() const { return answers_; }

 private:
  std::deque<PastAnswer> answers_;
};

[[nodiscard]] Json render_history(std::string_view session, const std::deque<PastAnswer>& answers);

}  // namespace cornerfix::api
