#include "server/responses.hpp"

#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "server/event_log.hpp"

namespace cornerfix::server {

Response document_response(const Request& request, int status, const api::Json& document) {
  return {.status = status,
          .content_type = std::string(api::media_type(request.answer_format)),
          .body = api::encode(document, request.answer_format)};
}

Response text_response(const Request& request, int status, const std::string& json) {
  if (request.answer_format == api::BodyFormat::kJson) return json_response(status, json);
  return document_response(request, status, api::Json::parse(json));
}

Response error_response(const Request& request, const Error& error) {
  const api::Problem problem = api::to_problem(error);
  if (problem.status >= 500) {
    spdlog::error("{} {}{}{}", request.id, printable(error.message),
                  error.field.empty() ? "" : " at ", printable(error.field));
  }
  return problem_response(problem);
}

}  // namespace cornerfix::server
