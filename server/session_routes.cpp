#include <nlohmann/json.hpp>

#include "api/answer_history.hpp"
#include "api/answer_profiles.hpp"
#include "api/json_codec.hpp"
#include "server/page_query.hpp"
#include "server/responses.hpp"
#include "server/routes.hpp"
#include "server/used_versions.hpp"

namespace cornerfix::server {
namespace {

using api::Json;

/// With the points for the inspector, as long as they are in memory. Null before the first answer.
Json last_answer_json(const SessionView& view) {
  if (view.last_answer.empty()) return nullptr;
  Json answer = Json::parse(view.last_answer);
  if (!view.last_scan) return answer;
  return api::with_points(std::move(answer), *view.last_scan, view.feature_points);
}

Json session_json(const SessionView& view, UsedVersions& versions) {
  const Json answer = last_answer_json(view);
  Json session = api::render_session({.id = view.id,
                                      .robot = view.robot,
                                      .maps = view.maps,
                                      .created = view.created,
                                      .last_seen = view.last_seen,
                                      .is_stale = view.is_stale,
                                      .superseded_by = view.superseded_by,
                                      .expected = view.expected_sequence,
                                      .lidars = view.lidars,
                                      .params = view.params,
                                      .region = view.region,
                                      .last_answer = answer.is_null() ? nullptr : &answer,
                                      .is_damaged = view.is_damaged});
  session["status"] = to_string(view.status);
  session["map_version"] = versions.of(answer);
  return session;
}

/// Names the profile that a document was written in.
Response profiled(const Request& request, Response response) {
  if (request.answer_profile != api::AnswerProfile::kPlain)
    response.content_type += "; profile=" + std::string(to_string(request.answer_profile));
  return response;
}

/// A rendered answer, in the profile that was asked for.
Response answer_response(const Request& request, const std::string& answer) {
  if (request.answer_profile == api::AnswerProfile::kPlain)
    return text_response(request, 200, answer);
  return profiled(request,
                  document_response(request, 200,
                                    api::in_profile(Json::parse(answer), request.answer_profile)));
}

/// The problem for an error of a session's call.
Response session_error(const Request& request, const Error& error) {
  Response response = error_response(request, error);
  const bool is_damaged = error.code == ErrorCode::kCorruptData && error.field == "session";
  if (!is_damaged) return response;
  return problem_response(500, "corrupt_data",
                          "What is stored of the session is damaged: delete the session and create "
                          "another. The server's log has the details, by the request's id.");
}

Response forbidden_robot() {
  return problem_response(403, "forbidden", "A robot's token is for its own sessions only.");
}

Response forbidden_map(const std::string& map) {
  return problem_response(403, "forbidden", "The token is not for the map " + map + ".");
}

class SessionRoutes {
 public:
  explicit SessionRoutes(Services services) : services_(std::move(services)) {}

  Response create(const Request& request) {
    const auto parsed = api::parse_create_session(request.body, request.body_format);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    auto session = std::get<api::CreateSessionRequest>(parsed);
    if (!request.principal.may_see(session.robot)) return forbidden_robot();
    if (session.maps.empty()) session.maps = request.principal.maps;
    for (const std::string& map : session.maps) {
      if (!request.principal.may_use(map)) return forbidden_map(map);
    }
    if (auto refusal = refuse_growth(services_, request)) return std::move(*refusal);
    const auto created = service().create(session);
    if (!created) return error_response(request, created.error());
    if (!*created) return too_many_sessions(session.robot);
    const SessionView& view = **created;
    Response response = document_response(request, 201, one_session(view));
    response.headers.emplace_back("Location", "/v1/sessions/" + view.id);
    return response;
  }

  Response list(const Request& request) {
    const auto parsed = page_query(request);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    const auto& page = std::get<PageQuery>(parsed);
    // A robot sees its own only.
    const bool is_robot = request.principal.role == Role::kRobot;
    const auto list = service().list({.robot = is_robot ? request.principal.name : std::string(),
                                      .after = page.after,
                                      .limit = page.limit});
    if (!list) return error_response(request, list.error());
    Json sessions = Json::array();
    UsedVersions versions(*services_.maps);
    for (const SessionView& view : list->sessions) sessions.push_back(session_json(view, versions));
    Json next = list->next ? Json(std::to_string(*list->next)) : Json(nullptr);
    return document_response(
        request, 200,
        Json{{"sessions", std::move(sessions)}, {"next_page_token", std::move(next)}});
  }

  Response get(const Request& request) {
    const auto view = service().find(request.captures[0]);
    if (!view) return session_error(request, view.error());
    if (!request.principal.may_see(view->robot)) return forbidden_robot();
    return profiled(request, document_response(request, 200,
                                               api::session_in_profile(one_session(*view),
                                                                       request.answer_profile)));
  }

  Response remove(const Request& request) {
    if (auto refusal = refuse_foreign(request)) return *refusal;
    const auto removed = service().remove(request.captures[0]);
    if (!removed) return error_response(request, removed.error());
    services_.events->end(request.captures[0]);
    return Response{.status = 204};
  }

  Response reset(const Request& request) {
    if (auto refusal = refuse_foreign(request)) return *refusal;
    const auto parsed = api::parse_reset(request.body, request.body_format);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    const auto& reset = std::get<api::ResetRequest>(parsed);
    const auto view = service().reset(request.captures[0], reset.region);
    if (!view) return session_error(request, view.error());
    return document_response(request, 200, one_session(*view));
  }

  Response post_scans(const Request& request) {
    const std::string& id = request.captures[0];
    const auto head = service().head(id);
    if (!head) return session_error(request, head.error());
    if (!request.principal.may_see(head->robot)) return forbidden_robot();
    const auto parsed =
        api::parse_session_scans(request.body, request.body_format, head->lidars, services_.limits);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    const auto& batch = std::get<api::SessionScansRequest>(parsed);
    const auto outcome = service().post_scans(id, batch);
    if (!outcome) return session_error(request, outcome.error());
    if (outcome->expected_sequence) return sequence_conflict(batch.sequence, *outcome);
    return answer_response(request, outcome->answer);
  }

  Response localize(const Request& request) {
    const std::string& map = request.captures[0];
    if (!request.principal.may_use(map)) return forbidden_map(map);
    if (const auto info = services_.maps->find(map); !info) {
      return error_response(request, info.error());
    }
    const auto parsed = api::parse_localize(request.body, request.body_format, services_.limits);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    const auto answer = service().localize(map, std::get<api::LocalizeRequest>(parsed));
    if (!answer) return error_response(request, answer.error());
    return answer_response(request, *answer);
  }

  Response history(const Request& request) {
    if (auto refusal = refuse_foreign(request)) return *refusal;
    const auto answers = service().history(request.captures[0]);
    if (!answers) return session_error(request, answers.error());
    return document_response(request, 200, api::render_history(request.captures[0], *answers));
  }

  Response events(const Request& request) {
    const std::string& id = request.captures[0];
    std::shared_ptr<EventSubscription> subscription;
    bool is_foreign = false;
    const auto found = service().visit(id, [&](const SessionView& view) {
      is_foreign = !request.principal.may_see(view.robot);
      if (!is_foreign) subscription = services_.events->subscribe(id);
      if (!subscription) return;
      if (auto event = last_answer_event(view)) subscription->push(std::move(*event));
    });
    if (!found) return session_error(request, found.error());
    if (is_foreign) return forbidden_robot();
    if (!subscription) {
      return problem_response(503, "too_many_event_clients",
                              "Too many clients listen to events; try again later.");
    }
    return Response{.content_type = "text/event-stream",
                    .headers = {{"Cache-Control", "no-store"}},
                    .events = subscription};
  }

 private:
  Json one_session(const SessionView& view) {
    UsedVersions versions(*services_.maps);
    return session_json(view, versions);
  }

  LocalizationService& service() { return *services_.localization; }

  std::optional<Response> refuse_foreign(const Request& request) {
    const auto robot = service().robot_of(request.captures[0]);
    if (!robot) return error_response(request, robot.error());
    if (!request.principal.may_see(*robot)) return forbidden_robot();
    return std::nullopt;
  }

  Response too_many_sessions(const std::string& robot) {
    return over_quota(services_, "too_many_sessions",
                      "Robot " + robot +
                          " has as many sessions as it may have (max_sessions_per_robot), or the "
                          "server has (max_sessions): go on in one of them, or delete some.");
  }

  static Response sequence_conflict(std::uint64_t sequence, const BatchOutcome& outcome) {
    const std::string expected = std::to_string(*outcome.expected_sequence);
    const std::string detail =
        outcome.is_another_batch
            ? "Sequence " + std::to_string(sequence) +
                  " was answered for a batch with other scans; the session expects " + expected +
                  "."
            : "The batch has sequence " + std::to_string(sequence) + "; the session expects " +
                  expected + ".";
    return problem_response(
        api::Problem{.status = 409,
                     .code = "sequence_conflict",
                     .title = "Wrong sequence",
                     .detail = detail,
                     .errors = {},
                     .conflict = {{*outcome.expected_sequence, outcome.last_stamp}}});
  }

  Services services_;
};

}  // namespace

std::optional<std::string> last_answer_event(const SessionView& view) {
  const Json answer = last_answer_json(view);
  if (answer.is_null()) return std::nullopt;
  return format_answer_event(view.expected_sequence - 1,
                             api::encode(answer, api::BodyFormat::kJson));
}

void add_session_routes(Router& router, const Services& services) {
  const auto add = adder_of(router, std::make_shared<SessionRoutes>(services));
  using enum BodyRule;
  add("POST", "/v1/sessions", Access::kSession, kDocument, &SessionRoutes::create);
  add("GET", "/v1/sessions", Access::kRead, kIgnored, &SessionRoutes::list,
      {"limit", "page_token"});
  add("GET", "/v1/sessions/{id}", Access::kRead, kIgnored, &SessionRoutes::get);
  add("DELETE", "/v1/sessions/{id}", Access::kSession, kIgnored, &SessionRoutes::remove);
  add("POST", "/v1/sessions/{id}/reset", Access::kSession, kOptionalDocument,
      &SessionRoutes::reset);
  add("POST", "/v1/sessions/{id}/scans", Access::kSession, kScanBatch, &SessionRoutes::post_scans);
  add("GET", "/v1/sessions/{id}/history", Access::kRead, kIgnored, &SessionRoutes::history);
  add("GET", "/v1/sessions/{id}/events", Access::kRead, kIgnored, &SessionRoutes::events);
  add("POST", "/v1/maps/{map}/localize", Access::kSession, kDocument, &SessionRoutes::localize);
}

}  // namespace cornerfix::server
