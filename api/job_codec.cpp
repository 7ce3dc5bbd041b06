#include "api/job_codec.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace cornerfix::api {
namespace {

Json text_or_null(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }

}  // namespace

Json render_job(const JobEntry& job) {
  const std::string path = "/v1/jobs/" + std::string(job.id);
  return {{"id", job.id},
          {"kind", job.kind},
          {"map", job.map},
          {"status", job.status},
          {"stage", text_or_null(job.stage)},
          {"progress", job.progress},
          {"cancelling", job.is_cancelling},
          {"created", job.created},
          {"started", text_or_null(job.started)},
          {"finished", text_or_null(job.finished)},
          {"problem", job.problem.empty() ? Json(nullptr) : Json::parse(job.problem)},
          {"result", job.has_result ? Json(path + "/result") : Json(nullptr)}};
}

Json render_job_list(std::span<const JobEntry> jobs,
                     std::optional<std::string_view> next_page_token) {
  Json list = Json::array();
  for (const JobEntry& job : jobs) list.push_back(render_job(job));
  return {{"jobs", std::move(list)},
          {"next_page_token", next_page_token ? Json(*next_page_token) : Json(nullptr)}};
}

}  // namespace cornerfix::api
