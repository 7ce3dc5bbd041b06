/// \file  Content-Type and Accept, as far as this service has something to choose from.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/answer_profiles.hpp"
#include "api/requests.hpp"

namespace cornerfix::server {

inline constexpr const char* kBinaryBatchType = "application/octet-stream";

/// A Content-Type in lower case, without its parameters.
[[nodiscard]] std::string media_type_of(std::string_view content_type);

/// The format of a body with this Content-Type, or nothing when it is none of ours. Without any
/// Content-Type a body is taken as JSON.
[[nodiscard]] std::optional<api::BodyFormat> format_of_content_type(std::string_view content_type);

/// How an answer is written.
struct AnswerFormat {
  api::BodyFormat body = api::BodyFormat::kJson;
  api::AnswerProfile profile = api::AnswerProfile::kPlain;
  friend bool operator==(const AnswerFormat&, const AnswerFormat&) = default;
};

/// What an Accept header likes best; JSON when it does not care or likes none of ours. A profile
/// that is not known is as none.
[[nodiscard]] AnswerFormat best_format(std::string_view accept);

}  // namespace cornerfix::server
