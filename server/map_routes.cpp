#include <charconv>
#include <chrono>
#include <nlohmann/json.hpp>
#include <span>

#include <cornerfix/map_image.hpp>

#include "api/json_codec.hpp"
#include "api/report_codec.hpp"
#include "server/entity_tag.hpp"
#include "server/job_runners.hpp"
#include "server/map_entries.hpp"
#include "server/responses.hpp"
#include "server/routes.hpp"

namespace cornerfix::server {
namespace {

using api::Json;
using storage::JobMap;
using storage::KnownMap;
using storage::MapInfo;

constexpr std::size_t kDefaultPage = 100;
constexpr std::size_t kDefaultReportWait = 20;  // [s]

Response invalid_map_name() {
  api::Problem problem = api::make_problem(
      ErrorCode::kInvalidArgument, "A map's name matches [A-Za-z0-9][A-Za-z0-9._-]{0,127}.");
  problem.errors = {{"/map", "not a valid name"}};
  return problem_response(problem);
}

Response unusable_form(std::vector<api::FieldError> wrong) {
  api::Problem problem =
      api::make_problem(ErrorCode::kInvalidArgument,
                        "Send the parts yaml and image: -F yaml=@MAP.yaml -F image=@MAP.pgm");
  problem.errors = std::move(wrong);
  return problem_response(problem);
}

std::optional<std::uint64_t> whole_number(const std::string& text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc{} && end == text.data() + text.size();
  return is_number ? std::optional(number) : std::nullopt;
}

Response wrong_revision() {
  api::Problem problem =
      api::make_problem(ErrorCode::kInvalidArgument, "revision: must be a whole number");
  problem.errors = {{"/revision", "must be a whole number"}};
  return problem_response(problem);
}

Response no_such_feature(const std::string& id) {
  return problem_response(404, "not_found", "There is no feature " + id + " in this revision.");
}

/// Lets a client that holds this content already save the transfer.
Response with_entity_tag(const Request& request, Response response, const MapInfo& info,
                         std::string_view kind) {
  const std::string tag = "W/\"" + info.digest + "-" + std::string(kind) + "\"";
  response.headers.emplace_back("ETag", tag);
  response.headers.emplace_back("Cache-Control", "no-cache");
  if (names_entity_tag(request.if_none_match, tag)) {
    response.status = 304;
    response.body.clear();
  }
  return response;
}

/// Names what a change of the map is to start from.
std::string entity_tag_of(const MapInfo& info) {
  return map_entity_tag(info.revision, info.digest, info.description);
}

/// Names the content of a map alone.
std::string digest_tag_of(const MapInfo& info) { return "\"" + info.digest + "\""; }

/// Whether an If-Match header names the map as it is, by its tag or its digest.
bool is_as_required(std::string_view if_match, const MapInfo& info) {
  return requires_entity_tag(if_match, entity_tag_of(info)) ||
         requires_entity_tag(if_match, digest_tag_of(info));
}

Response entry_response(const Request& request, int status, const MapInfo& info) {
  Response response = document_response(request, status, api::render_map(entry_of(info)));
  response.headers.emplace_back("ETag", entity_tag_of(info));
  return response;
}

JobMap job_map(const MapInfo& info) { return {.revision = info.revision, .id = info.id}; }

/// A change that was asked for with If-Match and came too late is 412 (RFC 9110, 13.1.1).
Response change_error(const Request& request, const Error& error) {
  const bool came_too_late = error.code == ErrorCode::kConflict && error.field == "revision";
  if (!request.if_match || !came_too_late) return error_response(request, error);
  return problem_response(412, "precondition_failed", error.message);
}

class MapRoutes {
 public:
  explicit MapRoutes(Services services) : services_(std::move(services)) {}

  Response list(const Request& request) {
    std::size_t limit = kDefaultPage;
    if (const auto text = request.parameter("limit")) {
      const auto parsed = api::parse_page_limit(*text);
      if (const auto* problem = std::get_if<api::Problem>(&parsed)) {
        return problem_response(*problem);
      }
      limit = std::get<std::size_t>(parsed);
    }
    auto infos = maps().list(request.parameter("page_token").value_or(""), limit + 1);
    if (!infos) return error_response(request, infos.error());
    const bool has_more = infos->size() > limit;
    if (has_more) infos->pop_back();
    std::vector<api::MapEntry> entries;
    for (const MapInfo& info : *infos) entries.push_back(entry_of(info));
    std::optional<std::string_view> next;
    if (has_more) next = infos->back().name;
    return document_response(request, 200, api::render_map_list(entries, next));
  }

  Response put(const Request& request) {
    const std::string& name = request.captures[0];
    if (!api::is_valid_name(name)) return invalid_map_name();
    const auto parsed = api::parse_put_map(request.body, request.body_format);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    if (auto refusal = refuse_new_map(request)) return std::move(*refusal);
    const auto expected = expected_map(request);
    if (!expected) return change_error(request, expected.error());
    const auto created = maps().put(name, std::get<api::PutMapRequest>(parsed), *expected);
    if (!created) return change_error(request, created.error());
    const auto info = maps().find(name);
    if (!info) return error_response(request, info.error());
    Response response = entry_response(request, *created ? 201 : 200, *info);
    if (*created) response.headers.emplace_back("Location", "/v1/maps/" + name);
    return response;
  }

  Response get(const Request& request) {
    const auto info = maps().find(request.captures[0]);
    if (!info) return error_response(request, info.error());
    return entry_response(request, 200, *info);
  }

  Response remove(const Request& request) {
    const auto info = maps().find(request.captures[0]);
    if (!info) return error_response(request, info.error());
    const auto expected = expected_map(request);
    if (!expected) return change_error(request, expected.error());
    const auto removed = maps().remove(info->name, *expected);
    if (!removed) return change_error(request, removed.error());
    services_.reports->forget(info->id);
    return Response{.status = 204};
  }

  Response post_scans(const Request& request) {
    const std::string& name = request.captures[0];
    const auto info = maps().find(name);
    if (!info) return error_response(request, info.error());
    const bool is_run = request.preference.respond_async;
    const auto parsed = api::parse_map_scans(
        request.body, request.body_format, api::lidar_from_json(info->lidar_json),
        is_run ? limits_of_runs(services_.limits) : services_.limits);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    const auto& batch = std::get<api::MapScansRequest>(parsed);
    if (auto refusal = refuse_growth(services_, request)) return std::move(*refusal);
    const auto expected = expected_map(request);
    if (!expected) return change_error(request, expected.error());
    if (is_run) {
      return accept_change_job(
          request, kMappingJob,
          {{"run", request.body}, {"type", api::media_type(request.body_format)}}, *expected);
    }
    const auto report = batch.unposed_scans.empty()
                            ? maps().grow(name, batch.scans, *expected)
                            : maps().grow(name, batch.unposed_scans, *expected);
    if (!report) return change_error(request, report.error());
    return document_response(request, 200, api::render_map_batch(entry_of(*report)));
  }

  Response put_trajectory(const Request& request) {
    const std::string& name = request.captures[0];
    if (const auto info = maps().find(name); !info) return error_response(request, info.error());
    const auto parsed = api::parse_trajectory(request.body, request.body_format);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    const auto expected = expected_map(request);
    if (!expected) return change_error(request, expected.error());
    const auto moved =
        maps().set_trajectory(name, std::get<api::TrajectoryRequest>(parsed).poses, *expected);
    if (!moved) return change_error(request, moved.error());
    return entry_response(request, 200, *moved);
  }

  Response put_grid(const Request& request) {
    const std::string& name = request.captures[0];
    if (!api::is_valid_name(name)) return invalid_map_name();
    std::vector<api::FieldError> wrong;
    for (const char* part : {"yaml", "image"}) {
      if (!request.parts.contains(part)) wrong.push_back({std::string("/") + part, "missing"});
    }
    for (const auto& [part, content] : request.parts) {
      if (part != "yaml" && part != "image")
        wrong.push_back({"/" + part, "not known, expected yaml and image only"});
    }
    if (!wrong.empty()) return unusable_form(std::move(wrong));
    if (auto refusal = refuse_new_map(request)) return std::move(*refusal);
    const auto expected = expected_map(request);
    if (!expected) return change_error(request, expected.error());
    if (request.preference.respond_async) {
      return accept_change_job(
          request, kImportJob,
          {{"yaml", request.parts.at("yaml")}, {"image", request.parts.at("image")}}, *expected);
    }
    const auto report =
        maps().put_floor_map(name, request.parts.at("yaml"),
                             std::as_bytes(std::span(request.parts.at("image"))), {}, *expected);
    if (!report) return change_error(request, report.error());
    Response response = document_response(request, report->created ? 201 : 200,
                                          api::render_floor_map(entry_of(*report)));
    if (report->created) response.headers.emplace_back("Location", "/v1/maps/" + name);
    return response;
  }

  Response get_archive(const Request& request) {
    const std::string& name = request.captures[0];
    std::optional<std::uint64_t> revision;
    if (const auto text = request.parameter("revision")) {
      revision = whole_number(*text);
      if (!revision) return wrong_revision();
    }
    const auto bytes = revision ? maps().archive(name, *revision) : maps().archive(name);
    if (!bytes) return error_response(request, bytes.error());
    Response response{.content_type = kArchiveType, .body = {bytes->begin(), bytes->end()}};
    response.headers.emplace_back("Content-Disposition",
                                  "attachment; filename=\"" + name + ".cornerfix\"");
    return response;
  }

  Response post_archive(const Request& request) {
    const std::string& name = request.captures[0];
    if (!api::is_valid_name(name)) return invalid_map_name();
    if (auto refusal = refuse_new_map(request)) return std::move(*refusal);
    const auto expected = expected_map(request);
    if (!expected) return change_error(request, expected.error());
    if (request.preference.respond_async)
      return accept_change_job(request, kRestoreJob, {{"archive", request.body}}, *expected);
    const auto bytes = std::as_bytes(std::span(request.body));
    const auto info =
        maps().restore(name, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    if (!info) return error_response(request, info.error());
    Response response = entry_response(request, 201, *info);
    response.headers.emplace_back("Location", "/v1/maps/" + name);
    return response;
  }

  Response revisions(const Request& request) {
    const auto revisions = maps().revisions(request.captures[0]);
    if (!revisions) return error_response(request, revisions.error());
    return document_response(request, 200, revisions_of(request.captures[0], *revisions));
  }

  Response roll_back(const Request& request) {
    const std::string& name = request.captures[0];
    const auto parsed = api::parse_roll_back(request.body, request.body_format);
    if (const auto* problem = std::get_if<api::Problem>(&parsed)) return problem_response(*problem);
    if (auto refusal = refuse_growth(services_, request)) return std::move(*refusal);
    const auto expected = expected_map(request);
    if (!expected) return change_error(request, expected.error());
    const auto info =
        maps().roll_back(name, std::get<api::RollBackRequest>(parsed).revision, *expected);
    if (!info) return change_error(request, info.error());
    return entry_response(request, 200, *info);
  }

  Response features(const Request& request) {
    std::optional<Bounds> box;
    if (const auto text = request.parameter("bbox")) {
      const auto parsed = api::parse_bbox(*text);
      if (const auto* problem = std::get_if<api::Problem>(&parsed)) {
        return problem_response(*problem);
      }
      box = std::get<Bounds>(parsed);
    }
    const auto map = maps().load(request.captures[0]);
    if (!map) return error_response(request, map.error());
    return document_response(request, 200,
                             api::render_features((*map)->revision(), (*map)->features(), box));
  }

  Response descriptor(const Request& request) {
    const auto map = maps().load(request.captures[0]);
    if (!map) return error_response(request, map.error());
    const std::string& id = request.captures[1];
    const auto number = whole_number(id);
    if (!number || *number >= (*map)->features().size()) return no_such_feature(id);
    const std::size_t feature = *number;
    const DescriptorParams& params = (*map)->descriptor_params();
    return document_response(
        request, 200,
        api::render_descriptor((*map)->revision(), feature, params,
                               describe_one((*map)->features(), feature, params)));
  }

  Response grid_png(const Request& request) {
    return grid_file(request, "image/png", [](const OccupancyGrid& grid) {
      const auto png = encode_grid_png(grid);
      return std::string(reinterpret_cast<const char*>(png.data()), png.size());
    });
  }

  Response grid_yaml(const Request& request) {
    return grid_file(request, "application/yaml",
                     [](const OccupancyGrid& grid) { return encode_grid_yaml(grid, "grid.png"); });
  }

  Response report(const Request& request) {
    if (request.preference.respond_async && may(request.principal.role, Access::kMap))
      return accept_report_job(request);
    return when_report_is_made(
        request, [&](const MapInfo& info, const ReportView& view) -> Response {
          return document_response(request, 200,
                                   api::render_report({info.name, view.revision}, *view.report));
        });
  }

  Response report_picture(const Request& request) {
    return when_report_is_made(
        request, [&](const MapInfo& info, const ReportView& view) -> Response {
          const auto grid = maps().grid(info);
          if (!grid) return error_response(request, grid.error());
          return {.content_type = "image/svg+xml", .body = api::draw_report(*view.report, *grid)};
        });
  }

 private:
  /// The answer to a call that would make a map where there is no room for one, or make one larger.
  std::optional<Response> refuse_new_map(const Request& request) {
    if (auto refusal = refuse_growth(services_, request)) return refusal;
    const auto info = maps().find(request.captures[0]);
    if (info) return std::nullopt;
    if (info.error().code != ErrorCode::kNotFound) return error_response(request, info.error());
    const auto count = maps().count();
    if (!count) return error_response(request, count.error());
    if (*count < services_.quotas.maps) return std::nullopt;
    return over_quota(services_, "too_many_maps",
                      "There are as many maps as there may be (max_maps): delete some.");
  }

  /// The map, where If-Match names it; any without the header.
  Result<ExpectedMap> expected_map(const Request& request) {
    if (!request.if_match) return ExpectedMap{};
    const auto info = maps().find(request.captures[0]);
    if (!info && info.error().code != ErrorCode::kNotFound) return info.error();
    if (!info || !is_as_required(*request.if_match, *info)) {
      return Error{ErrorCode::kConflict,
                   "If-Match names neither the map's ETag " +
                       (info ? entity_tag_of(*info) : "(there is no map)") + " nor its digest",
                   "revision"};
    }
    KnownMap known{.revision = info->revision, .id = info->id};
    if (!requires_entity_tag(*request.if_match, digest_tag_of(*info)))
      known.description = info->description;
    return ExpectedMap(std::move(known));
  }

  template <typename Encode>
  Response grid_file(const Request& request, const char* content_type, Encode encode) {
    const auto info = maps().find(request.captures[0]);
    if (!info) return error_response(request, info.error());
    const auto grid = maps().grid(*info);
    if (!grid) return error_response(request, grid.error());
    if (grid->cells.empty()) return error_response(request, map_without_grid());
    Response response{.content_type = content_type, .body = encode(*grid)};
    return with_entity_tag(request, std::move(response), *info, content_type);
  }

  /// Of a job that changes the map, or makes it.
  Response accept_change_job(const Request& request, const char* kind, const JobInputView& input,
                             const ExpectedMap& expected) {
    if (expected)
      return accept_job(services_, request, kind, input,
                        JobMap{expected->revision, expected->id, true});
    const auto info = maps().find(request.captures[0]);
    if (!info && info.error().code != ErrorCode::kNotFound)
      return error_response(request, info.error());
    return accept_job(services_, request, kind, input, info ? job_map(*info) : JobMap{});
  }

  Response accept_report_job(const Request& request) {
    const auto info = maps().find(request.captures[0]);
    if (!info) return error_response(request, info.error());
    if (!info->bounds) return error_response(request, map_without_grid());
    return accept_job(services_, request, kReportJob, {}, job_map(*info));
  }

  template <typename Render>
  Response when_report_is_made(const Request& request, Render render) {
    std::size_t wait_s = kDefaultReportWait;
    if (const auto text = request.parameter("wait")) {
      const auto parsed = api::parse_wait(*text);
      if (const auto* problem = std::get_if<api::Problem>(&parsed)) {
        return problem_response(*problem);
      }
      wait_s = std::get<std::size_t>(parsed);
    }
    const auto info = maps().find(request.captures[0]);
    if (!info) return error_response(request, info.error());
    if (!info->bounds) return error_response(request, map_without_grid());
    const auto view = services_.reports->get(*info, std::chrono::seconds(wait_s));
    if (!view) return error_response(request, view.error());
    if (view->report) return render(*info, *view);
    Response response = document_response(
        request, 202, api::render_report_progress({info->name, view->revision}, view->progress));
    response.headers.emplace_back("Retry-After", "1");
    return response;
  }

  MapLibrary& maps() { return *services_.maps; }

  Services services_;
};

}  // namespace

void add_map_routes(Router& router, const Services& services) {
  const auto add = adder_of(router, std::make_shared<MapRoutes>(services));
  using enum BodyRule;
  add("GET", "/v1/maps", Access::kRead, kIgnored, &MapRoutes::list, {"limit", "page_token"});
  add("PUT", "/v1/maps/{map}", Access::kMap, kOptionalDocument, &MapRoutes::put);
  add("GET", "/v1/maps/{map}", Access::kRead, kIgnored, &MapRoutes::get);
  add("DELETE", "/v1/maps/{map}", Access::kMap, kIgnored, &MapRoutes::remove);
  add("POST", "/v1/maps/{map}/scans", Access::kMap, kRun, &MapRoutes::post_scans);
  add("PUT", "/v1/maps/{map}/trajectory", Access::kMap, kDocument, &MapRoutes::put_trajectory);
  add("PUT", "/v1/maps/{map}/grid", Access::kMap, kForm, &MapRoutes::put_grid);
  add("GET", "/v1/maps/{map}/revisions", Access::kRead, kIgnored, &MapRoutes::revisions);
  add("POST", "/v1/maps/{map}/rollback", Access::kMap, kDocument, &MapRoutes::roll_back);
  add("GET", "/v1/maps/{map}/archive", Access::kRead, kIgnored, &MapRoutes::get_archive,
      {"revision"});
  add("POST", "/v1/maps/{map}/archive", Access::kMap, kArchive, &MapRoutes::post_archive);
  add("GET", "/v1/maps/{map}/features", Access::kRead, kIgnored, &MapRoutes::features, {"bbox"});
  add("GET", "/v1/maps/{map}/features/{id}/descriptor", Access::kRead, kIgnored,
      &MapRoutes::descriptor);
  add("GET", "/v1/maps/{map}/grid.png", Access::kRead, kIgnored, &MapRoutes::grid_png);
  add("GET", "/v1/maps/{map}/grid.yaml", Access::kRead, kIgnored, &MapRoutes::grid_yaml);
  add("GET", "/v1/maps/{map}/report", Access::kRead, kIgnored, &MapRoutes::report, {"wait"});
  add("GET", "/v1/maps/{map}/report.svg", Access::kRead, kIgnored, &MapRoutes::report_picture,
      {"wait"});
}

}  // namespace cornerfix::server
