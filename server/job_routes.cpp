#include <nlohmann/json.hpp>

#include "api/job_codec.hpp"
#include "server/job_runners.hpp"
#include "server/map_entries.hpp"
#include "server/page_query.hpp"
#include "server/responses.hpp"
#include "server/routes.hpp"

namespace cornerfix::server {
namespace {

using storage::JobRecord;
using storage::JobStatus;

api::JobEntry job_entry_of(const JobRecord& job) {
  return {.id = job.id,
          .kind = job.kind,
          .map = job.map,
          .status = to_string(job.status),
          .stage = job.stage,
          .progress = job.progress,
          .is_cancelling = job.is_cancelling,
          .created = job.created,
          .started = job.started,
          .finished = job.finished,
          .problem = job.problem,
          .has_result = job.status == JobStatus::kSucceeded};
}

class JobRoutes {
 public:
  explicit JobRoutes(Services services) : services_(std::move(services)) {}

  Response list(const Request& request) {
    const auto parsed = page_query(request);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    const auto& page = std::get<PageQuery>(parsed);
    auto jobs = services_.jobs->list({.after = page.after, .limit = page.limit + 1});
    if (!jobs) return error_response(request, jobs.error());
    const bool has_more = jobs->size() > page.limit;
    if (has_more) jobs->pop_back();
    std::vector<api::JobEntry> entries;
    for (const JobRecord& job : *jobs) entries.push_back(job_entry_of(job));
    const std::string next = has_more ? std::to_string(jobs->back().number) : "";
    return document_response(
        request, 200,
        api::render_job_list(entries,
                             has_more ? std::optional<std::string_view>(next) : std::nullopt));
  }

  Response get(const Request& request) {
    const auto job = services_.jobs->find(request.captures[0]);
    if (!job) return error_response(request, job.error());
    return document_response(request, 200, api::render_job(job_entry_of(*job)));
  }

  Response result(const Request& request) {
    const auto answer = services_.jobs->answer(request.captures[0]);
    if (!answer) return error_response(request, answer.error());
    return text_response(request, 200, *answer);
  }

  Response cancel(const Request& request) {
    const auto job = services_.jobs->cancel(request.captures[0]);
    if (!job) return error_response(request, job.error());
    return document_response(request, 200, api::render_job(job_entry_of(*job)));
  }

 private:
  Services services_;
};

Response accepted_job(const Request& request, const JobRecord& job) {
  Response response = document_response(request, 202, api::render_job(job_entry_of(job)));
  response.headers.emplace_back("Location", "/v1/jobs/" + job.id);
  response.headers.emplace_back("Preference-Applied", "respond-async");
  return response;
}

/// Of a map's entry as text: the map itself may have changed by now.
std::string tag_of_entry(const std::string& text) {
  const auto entry = api::Json::parse(text);
  return map_entity_tag(entry.at("revision").get<std::uint64_t>(),
                        entry.at("digest").get<std::string>(),
                        entry.at("description").get<std::string>());
}

/// The answer that the request would have got without a job, if the job is finished by now.
Response response_of_finished(const Services& services, const Request& request,
                              const JobRecord& job, bool makes_a_map) {
  if (job.status == JobStatus::kFailed) {
    const auto problem = api::Json::parse(job.problem);
    return {.status = problem.at("status").get<int>(),
            .content_type = kProblemType,
            .body = job.problem};
  }
  if (job.status != JobStatus::kSucceeded) return accepted_job(request, job);
  const auto answer = services.jobs->answer(job.id);
  if (!answer) return error_response(request, answer.error());
  Response response = text_response(request, makes_a_map ? 201 : 200, *answer);
  if (makes_a_map) response.headers.emplace_back("Location", "/v1/maps/" + job.map);
  if (job.kind == kRestoreJob) response.headers.emplace_back("ETag", tag_of_entry(*answer));
  return response;
}

}  // namespace

Response accept_job(const Services& services, const Request& request, const char* kind,
                    const JobInputView& input, const storage::JobMap& map) {
  std::map<std::string, storage::BlobView> blobs;
  for (const auto& [name, content] : input) {
    blobs.emplace(name, storage::BlobView(reinterpret_cast<const std::uint8_t*>(content.data()),
                                          content.size()));
  }
  const auto job = services.jobs->submit(kind, request.captures[0], blobs, map);
  if (!job) return error_response(request, job.error());
  if (!*job) {
    return over_quota(services, "too_many_jobs",
                      "As many jobs wait as may wait (max_jobs), or their input has as many bytes "
                      "as it may have (max_job_bytes): try again later, or cancel some.");
  }
  const auto wait = request.preference.wait;
  if (!wait) return accepted_job(request, **job);
  const auto waited = services.jobs->wait_for((*job)->id, *wait);
  if (!waited) return error_response(request, waited.error());
  const bool makes_a_map = map.revision == 0;
  return response_of_finished(services, request, *waited, makes_a_map);
}

void add_job_routes(Router& router, const Services& services) {
  const auto add = adder_of(router, std::make_shared<JobRoutes>(services));
  using enum BodyRule;
  add("GET", "/v1/jobs", Access::kMap, kIgnored, &JobRoutes::list, {"limit", "page_token"});
  add("GET", "/v1/jobs/{id}", Access::kMap, kIgnored, &JobRoutes::get);
  add("GET", "/v1/jobs/{id}/result", Access::kMap, kIgnored, &JobRoutes::result);
  add("DELETE", "/v1/jobs/{id}", Access::kMap, kIgnored, &JobRoutes::cancel);
}

}  // namespace cornerfix::server
