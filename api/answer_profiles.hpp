/// \file  Answers and sessions in the shapes of other systems: messages of ROS, and VDA 5050.
#pragma once

#include <optional>
#include <string_view>

#include "api/json_codec.hpp"

namespace cornerfix::api {

/// The parameter `profile` of a media type.
enum class AnswerProfile { kPlain, kRos, kVda5050 };

[[nodiscard]] std::optional<AnswerProfile> answer_profile_from_string(std::string_view name);
[[nodiscard]] std::string_view to_string(AnswerProfile profile);

/// An answer of render_answer(). For ROS its poses become messages of geometry_msgs. For VDA 5050
/// it becomes the members of a state message that are about the position.
[[nodiscard]] Json in_profile(Json answer, AnswerProfile profile);

/// A session of render_session(): for ROS, its last answer becomes the above; for VDA 5050 it
/// becomes the above as a whole.
[[nodiscard]] Json session_in_profile(Json session, AnswerProfile profile);

}  // namespace cornerfix::api
