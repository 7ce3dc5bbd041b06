/// \file  A request and its response as routes see them: no HTTP library in sight.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/answer_profiles.hpp"
#include "api/problem.hpp"
#include "api/requests.hpp"
#include "server/access.hpp"
#include "server/preference.hpp"

namespace cornerfix::server {

class EventSubscription;

struct Request {
  std::string id;                     ///< The client's or ours, for the log and the answer.
  std::string traceparent;            ///< The client's, when it is one.
  std::string method;                 ///< As sent; only here a HEAD differs from a GET.
  std::vector<std::string> captures;  ///< Path segments that matched `{…}`, percent-decoded once.
  std::multimap<std::string, std::string> query;
  std::string body;  ///< Inflated.
  api::BodyFormat body_format = api::BodyFormat::kJson;
  std::map<std::string, std::string> parts;                        ///< Of a form, by name.
  api::BodyFormat answer_format = api::BodyFormat::kJson;          ///< By Accept,
  api::AnswerProfile answer_profile = api::AnswerProfile::kPlain;  ///< as this.
  std::string if_none_match;
  std::optional<std::string> if_match;
  Preference preference{};
  Principal principal;

  /// The first value of a query parameter.
  [[nodiscard]] std::optional<std::string> parameter(const std::string& name) const {
    const auto found = query.find(name);
    if (found == query.end()) return std::nullopt;
    return found->second;
  }
};

/// Every member has an initializer, so that a designated one may leave it out without a warning.
struct Response {
  int status = 200;
  std::string content_type{};
  std::string body{};
  std::vector<std::pair<std::string, std::string>> headers{};
  std::shared_ptr<EventSubscription> events{};  ///< When set, the body is this stream.
};

/// What every answer carries: the request's id, what browsers must not do with it, how it is
/// cached.
void add_common_headers(Response& response, const std::string& request_id);

/// The answer as text, with "Connection: close".
[[nodiscard]] std::string last_answer(const Response& response);

using Handler = std::function<Response(const Request&)>;

inline constexpr const char* kProblemType = "application/problem+json";

[[nodiscard]] Response json_response(int status, std::string json);
[[nodiscard]] Response problem_response(const api::Problem& problem);
/// A problem without wrong fields.
[[nodiscard]] Response problem_response(int status, std::string_view code, std::string detail);
/// A 429; the client may try again after `wait`.
[[nodiscard]] Response too_many_response(std::string_view code, std::string detail,
                                         std::chrono::seconds wait);

}  // namespace cornerfix::server
