#include "server/service_setup.hpp"

#include <chrono>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/json_codec.hpp"
#include "server/event_log.hpp"
#include "server/job_runners.hpp"
#include "server/responses.hpp"

namespace cornerfix::server {
namespace {

using SystemClock = std::chrono::system_clock;

double now_ms() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::string rendered(const AnswerToRender& answer) {
  return api::encode(api::render_answer(answer.answer, {.session = answer.session,
                                                        .sequence = answer.sequence,
                                                        .stamp = answer.stamp}),
                     api::BodyFormat::kJson);
}

/// What an operator wants to find again: when a robot was localized, lost, or its pose withdrawn.
void log_batch(const BatchOrigin& origin, const BatchEvents& batch) {
  for (const double seconds : batch.times_to_localization_s) {
    log_event("localized",
              {{"session", origin.session}, {"robot", origin.robot}, {"after_s", seconds}});
  }
  for (const auto& [cause, count] : batch.withdrawals) {
    log_event("withdrawn",
              {{"session", origin.session}, {"robot", origin.robot}, {"cause", to_string(cause)}});
  }
  if (batch.lost > 0) {
    log_event("lost", {{"session", origin.session},
                       {"robot", origin.robot},
                       {"reason", to_string(batch.reason)}});
  }
}

LocalizationServiceSettings localization_settings(const ServerConfig& config,
                                                  const std::shared_ptr<EventHub>& events,
                                                  const std::shared_ptr<Metrics>& metrics) {
  return {.render = rendered,
          .now = now_text,
          .clock_ms = now_ms,
          .on_batch =
              [events, metrics](const BatchOrigin& origin, const BatchEvents& batch,
                                const std::function<SessionView()>& view) {
                metrics->count_batch(batch);
                log_batch(origin, batch);
                if (!events->is_watched(origin.session)) return;
                if (const auto event = last_answer_event(view()))
                  events->publish(origin.session, *event);
              },
          .idle_time = std::chrono::minutes(config.session_idle_minutes),
          .max_session_bytes = config.max_session_bytes,
          .max_sessions = config.max_sessions,
          .max_sessions_per_robot = config.max_sessions_per_robot,
          .max_searched_map_bytes = config.max_searched_map_bytes,
          .recorded_answers = config.recorded_answers,
          .expired_before =
              [days = std::chrono::days(config.session_expiry_days)] {
                return time_text(SystemClock::now() - days);
              },
          .stale_before =
              [silence = std::chrono::seconds(config.session_stale_s)] {
                return time_text(SystemClock::now() - silence);
              },
          .checkpoint_interval = std::chrono::seconds(config.checkpoint_interval_s)};
}

JobServiceSettings job_settings(const ServerConfig& config,
                                const std::shared_ptr<Metrics>& metrics) {
  return {.now = now_text,
          .on_end = [metrics](std::string_view kind, storage::JobStatus status,
                              double seconds) { metrics->count_job(kind, status, seconds); },
          .expired_before =
              [hours = std::chrono::hours(config.job_expiry_hours)] {
                return time_text(SystemClock::now() - hours);
              },
          .limits = {.jobs = config.max_jobs, .bytes = config.max_job_bytes}};
}

}  // namespace

std::string time_text(SystemClock::time_point time) {
  const std::time_t seconds = SystemClock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::string text(sizeof "2000-01-01T00:00:00Z" - 1, '\0');
  std::strftime(text.data(), text.size() + 1, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

std::string now_text() { return time_text(SystemClock::now()); }

Result<Services> open_services(const ServerConfig& config, std::function<ServerLoad()> load) {
  auto stores =
      StoreAccess::open(config.database, storage::kDefaultBusyTimeoutMs, config.kept_revisions);
  if (!stores) return stores.error();
  Services services;
  services.stores = *stores;
  services.limits = config.request_limits;
  services.min_free_bytes = config.min_free_bytes;
  services.quotas = {.maps = config.max_maps, .database_bytes = config.max_database_bytes};
  services.draining = std::make_shared<std::atomic<bool>>(false);
  services.events = std::make_shared<EventHub>(config.max_event_clients);
  services.metrics = std::make_shared<Metrics>();
  services.maps = std::make_shared<MapLibrary>(
      *stores,
      MapLibraryLimits{.max_map_bytes = config.max_map_bytes, .max_mappers = config.max_mappers},
      now_text);
  services.ranking = std::make_shared<MapRanking>(*stores, services.maps);
  services.reports = std::make_shared<ReportService>(services.maps);
  services.jobs = std::make_shared<JobService>(
      *stores, make_job_runners(services.maps, services.reports, config.request_limits),
      job_settings(config, services.metrics));
  services.load = std::move(load);
  services.localization = std::make_shared<LocalizationService>(
      *stores, services.maps, localization_settings(config, services.events, services.metrics),
      services.ranking);
  return services;
}

}  // namespace cornerfix::server
