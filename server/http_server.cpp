#include "server/http_server.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/json_codec.hpp"
#include "server/access.hpp"
#include "server/connection_loop.hpp"
#include "server/event_hub.hpp"
#include "server/event_log.hpp"
#include "server/host_check.hpp"
#include "server/http_message.hpp"
#include "server/listen_socket.hpp"
#include "server/media_types.hpp"
#include "server/request_body.hpp"
#include "server/request_stream.hpp"
#include "server/request_trace.hpp"
#include "server/responses.hpp"
#include "server/router.hpp"
#include "server/routes.hpp"
#include "server/shared_files.hpp"
#include "server/static_files.hpp"
#include "server/worker_pool.hpp"

// Last, because its <resolv.h> defines a macro `_res` that breaks Eigen's headers after it.
#include <httplib.h>

namespace cornerfix::server {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t kKeepAliveRequests = 1'000'000;
constexpr std::chrono::seconds kHeartbeat{5};
constexpr std::size_t kStreamedRequests = 16;
constexpr std::size_t kReservedDescriptors = 128;  // For the database and files.
constexpr std::size_t kMaxTargetLength = 2048;     // The library matches paths by recursion.

/// The library's server without its sockets: it parses requests and writes answers.
class LibraryServer final : public httplib::Server {
 public:
  /// The library sends streams only as long as it has a listening socket; any number will do.
  LibraryServer() { svr_sock_ = 0; }

  /// Whether another request may follow on the connection.
  bool answer(RequestStream& stream) {
    bool is_closing = false;
    const bool was_answered =
        process_request(stream.bytes(), false, is_closing,
                        [&stream](const httplib::Request& request) { stream.watch(request); });
    return was_answered && !is_closing && !stream.is_closing();
  }
};

std::string time_text(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::string text(sizeof "2000-01-01T00:00:00Z" - 1, '\0');
  std::strftime(text.data(), text.size() + 1, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

std::string now_text() { return time_text(std::chrono::system_clock::now()); }

double now_ms() {
  return std::chrono::duration<double, std::milli>(SteadyClock::now().time_since_epoch()).count();
}

std::string random_prefix() {
  std::random_device random;
  return fmt::format("{:08x}", random());
}

bool may_have_body(std::string_view method) {
  return method == "POST" || method == "PUT" || method == "PATCH" || method == "DELETE";
}

/// A table that is not empty and lets nobody in.
std::shared_ptr<const TokenTable> nobodys_token() {
  const std::vector<storage::TokenRecord> expired = {
      {.name = "nobody", .role = "viewer", .expires = "1970-01-01T00:00:00Z"}};
  return std::make_shared<const TokenTable>(std::vector<Token>{}, expired);
}

/// Whether a browser sends this on behalf of another site's page.
bool is_cross_site(const httplib::Request& raw) {
  const std::string site = raw.get_header_value("Sec-Fetch-Site");
  return site == "cross-site" || site == "same-site";
}

Response uri_too_long() {
  return problem_response(414, "uri_too_long", "The request target is too long.");
}

/// Connections may not take the descriptors that the database needs.
std::size_t possible_connections(std::size_t wanted) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return wanted;
  const std::size_t descriptors = limit.rlim_cur;
  return std::min(wanted, descriptors - std::min(descriptors - 1, kReservedDescriptors));
}

}  // namespace

struct HttpServer::Impl {
  explicit Impl(ServerConfig the_config)
      : config(std::move(the_config)), hosts(config.listen, config.allowed_hosts) {}

  ServerConfig config;
  std::mutex tokens_mutex;
  std::shared_ptr<const TokenTable> tokens;  ///< Of configuration and database.
  std::uint64_t tokens_epoch = 0;            ///< Of the store when they were read.
  HostCheck hosts;                           ///< Used where there are no tokens.
  Services services;
  Router router;
  StaticFiles files;
  std::string id_prefix = random_prefix();
  std::atomic<std::uint64_t> next_id{1};
  std::atomic<std::size_t> in_work{0};
  int port = 0;
  LibraryServer http;
  std::optional<ConnectionLoop> connections;
  std::optional<WorkerPool> workers;  ///< Ends first: its jobs use all of the above.

  std::shared_ptr<const TokenTable> current_tokens();
  Result<void> open_services();
  void open_connections(ListenSocket listener);
  void set_up_http();
  bool dispatch(const RequestInWorkPtr& request);
  void work(const RequestInWorkPtr& request);

  void serve(const httplib::Request& raw, httplib::Response& out,
             const httplib::ContentReader* reader);
  void refuse_unread(const httplib::Request& raw, httplib::Response& out);
  std::string refuse_head(const Refusal& refusal);
  ServerLoad load();
  void log_batch(const BatchOrigin& origin, const BatchEvents& batch) const;
  void log_request(const Exchange& exchange, int status, double ms) const;
  std::string next_request_id() { return id_prefix + "-" + std::to_string(next_id++); }
  Response answer(Exchange& exchange);
  Response answer_by_route(Exchange& exchange);
  Response answer_by_file(Exchange& exchange, const PathSegments& path);
  std::optional<Response> refuse(Exchange& exchange, Access access);
  std::optional<Response> refuse_foreign_page(const httplib::Request& raw) const;
  void write(Exchange& exchange, Response response, httplib::Response& out);
};

/// Those of the database are read anew when another process has changed it. When that fails, the
/// old ones stay. A server with tokens does not become open when the last one is revoked.
std::shared_ptr<const TokenTable> HttpServer::Impl::current_tokens() {
  const auto epoch = services.stores->epoch();
  const std::lock_guard lock(tokens_mutex);
  if (tokens && (!epoch || *epoch == tokens_epoch)) return tokens;
  const auto stored = services.stores->tokens();
  if (!stored) return tokens;
  auto table = std::make_shared<const TokenTable>(config.tokens, *stored);
  const bool was_closed = tokens && !tokens->is_empty();
  if (was_closed && table->is_empty()) table = nobodys_token();
  tokens = std::move(table);
  tokens_epoch = epoch ? *epoch : 0;
  return tokens;
}

Result<void> HttpServer::Impl::open_services() {
  auto stores = StoreAccess::open(config.database);
  if (!stores) return stores.error();
  services.stores = *stores;
  services.limits = config.request_limits;
  services.min_free_bytes = config.min_free_bytes;
  services.draining = std::make_shared<std::atomic<bool>>(false);
  services.events = std::make_shared<EventHub>(config.max_event_clients);
  services.metrics = std::make_shared<Metrics>();
  services.maps = std::make_shared<MapLibrary>(
      *stores,
      MapLibraryLimits{.max_map_bytes = config.max_map_bytes, .max_mappers = config.max_mappers},
      now_text);
  services.reports = std::make_shared<ReportService>(services.maps);
  services.load = [this] { return load(); };
  const auto events = services.events;
  const auto metrics = services.metrics;
  services.localization = std::make_shared<LocalizationService>(
      *stores, services.maps,
      LocalizationServiceSettings{
          .render =
              [](const AnswerToRender& answer) {
                return api::encode(api::render_answer(answer.answer, {.session = answer.session,
                                                                      .sequence = answer.sequence,
                                                                      .stamp = answer.stamp}),
                                   api::BodyFormat::kJson);
              },
          .now = now_text,
          .clock_ms = now_ms,
          .on_batch =
              [this, events, metrics](const BatchOrigin& origin, const BatchEvents& batch,
                                      const std::function<SessionView()>& view) {
                metrics->count_batch(batch);
                log_batch(origin, batch);
                if (!events->is_watched(origin.session)) return;
                if (const auto event = last_answer_event(view()))
                  events->publish(origin.session, *event);
              },
          .idle_time = std::chrono::minutes(config.session_idle_minutes),
          .max_session_bytes = config.max_session_bytes,
          .max_sessions_per_robot = config.max_sessions_per_robot,
          .max_searched_map_bytes = config.max_searched_map_bytes,
          .recorded_answers = config.recorded_answers,
          .expired_before =
              [days = std::chrono::days(config.session_expiry_days)] {
                return time_text(std::chrono::system_clock::now() - days);
              },
          .stale_before =
              [silence = std::chrono::seconds(config.session_stale_s)] {
                return time_text(std::chrono::system_clock::now() - silence);
              }});
  router = make_router(services);
  files.mount("", config.web_root.empty() ? find_web_root() : config.web_root);
  files.mount("vendor/leaflet", config.leaflet_root);
  files.mount("vendor/chart", config.chart_root);
  return {};
}

void HttpServer::Impl::set_up_http() {
  http.set_keep_alive_max_count(kKeepAliveRequests);
  http.set_keep_alive_timeout(config.keep_alive_timeout_s);
  const auto serve_with_body = [this](const httplib::Request& raw, httplib::Response& out,
                                      const httplib::ContentReader& reader) {
    serve(raw, out, &reader);
  };
  http.set_pre_routing_handler([this](const httplib::Request& raw, httplib::Response& out) {
    using Handled = httplib::Server::HandlerResponse;
    if (may_have_body(raw.method) && raw.target.size() <= kMaxTargetLength) {
      return Handled::Unhandled;
    }
    serve(raw, out, nullptr);
    return Handled::Handled;
  });
  constexpr const char* kAnyPath = "[\\s\\S]*";
  http.Post(kAnyPath, serve_with_body);
  http.Put(kAnyPath, serve_with_body);
  http.Patch(kAnyPath, serve_with_body);
  http.Delete(kAnyPath, serve_with_body);
  // What the library refuses by itself: a method that it does not know, say.
  const httplib::Server::HandlerWithResponse refuse_broken = [this](const httplib::Request& raw,
                                                                    httplib::Response& out) {
    using Handled = httplib::Server::HandlerResponse;
    if (out.has_header("X-Request-Id")) return Handled::Unhandled;
    refuse_unread(raw, out);
    return Handled::Handled;
  };
  http.set_error_handler(refuse_broken);
  http.set_post_routing_handler([](const httplib::Request&, httplib::Response& out) {
    if (out.status == 204) out.headers.erase("Content-Length");
    out.headers.erase("Accept-Ranges");  // Ranges are ignored.
  });
}

void HttpServer::Impl::open_connections(ListenSocket listener) {
  connections.emplace(
      std::move(listener),
      ConnectionLimits{.connections = possible_connections(config.max_connections),
                       .connections_per_address = config.max_connections_per_address,
                       .streamed_requests = kStreamedRequests,
                       .idle_timeout = std::chrono::seconds(config.keep_alive_timeout_s),
                       .drain_timeout = std::chrono::seconds(config.drain_timeout_s)},
      [this](const RequestInWorkPtr& request) { return dispatch(request); },
      [this](const Refusal& refusal) { return refuse_head(refusal); });
  // Event streams and large bodies wait for their clients: they have threads beside the workers.
  workers.emplace(config.worker_threads + config.max_event_clients + kStreamedRequests,
                  std::chrono::milliseconds(config.queue_timeout_ms));
}

bool HttpServer::Impl::dispatch(const RequestInWorkPtr& request) {
  // The loop limits large bodies, which wait for their clients, as do event streams.
  const bool is_counted = !request->is_streamed();
  const std::size_t limit = config.max_requests_in_work + services.events->count();
  if (is_counted && in_work >= limit) return false;
  in_work += is_counted ? 1U : 0U;
  workers->enqueue([this, request, is_counted] {
    work(request);
    in_work -= is_counted ? 1U : 0U;
  });
  return true;
}

void HttpServer::Impl::work(const RequestInWorkPtr& request) {
  RequestStream stream(*request);
  const bool is_kept = http.answer(stream) && !request->is_streamed();
  connections->finish(request, stream.take_unsent(), is_kept);
}

ServerLoad HttpServer::Impl::load() {
  const WorkerPool::Load threads = workers ? workers->load() : WorkerPool::Load{};
  return {.connections = connections ? connections->count() : 0,
          .requests_in_work = in_work,
          .workers = threads.threads,
          .busy_workers = threads.busy,
          .event_clients = services.events->count()};
}

/// What an operator wants to find again: when a robot was localized, lost, or its pose withdrawn.
void HttpServer::Impl::log_batch(const BatchOrigin& origin, const BatchEvents& batch) const {
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

void HttpServer::Impl::log_request(const Exchange& exchange, int status, double ms) const {
  const Request& request = exchange.request;
  const bool is_of_session = exchange.route.starts_with("/v1/sessions/{id}");
  const std::string_view session = is_of_session ? request.captures.front() : std::string_view{};
  const bool is_robot = request.principal.role == Role::kRobot;
  log_event("request", {{"request_id", request.id},
                        {"trace_id", trace_id_of(request.traceparent)},
                        {"client", exchange.raw.remote_addr},
                        {"method", exchange.raw.method},
                        {"path", exchange.raw.target.substr(0, exchange.raw.target.find('?'))},
                        {"status", std::int64_t{status}},
                        {"ms", ms},
                        {"session", session},
                        {"robot", is_robot ? request.principal.name : ""}});
}

void HttpServer::Impl::refuse_unread(const httplib::Request& raw, httplib::Response& out) {
  Exchange exchange{.raw = const_cast<httplib::Request&>(raw), .reader = nullptr};
  exchange.close = true;
  exchange.request.id = next_request_id();
  Response response = problem_response(out.status, "malformed", "The request cannot be read.");
  log_request(exchange, response.status, 0.0);
  write(exchange, std::move(response), out);
}

std::string HttpServer::Impl::refuse_head(const Refusal& refusal) {
  Response response = problem_response(refusal.status, refusal.code, refusal.detail);
  const std::string id = next_request_id();
  log_event(
      "refused",
      {{"request_id", id}, {"status", std::int64_t{refusal.status}}, {"detail", refusal.detail}});
  services.metrics->count_request("none", "none", refusal.status, 0.0);
  if (refusal.status == 503) services.metrics->count_shed(refusal.code);
  add_common_headers(response, id);
  return last_answer(response);
}

void HttpServer::Impl::serve(const httplib::Request& raw, httplib::Response& out,
                             const httplib::ContentReader* reader) {
  const auto begin = SteadyClock::now();
  // The library's request is not const, it only hands it out so.
  Exchange exchange{.raw = const_cast<httplib::Request&>(raw), .reader = reader};
  exchange.framing = framing_of(raw);
  const std::string given_id = raw.get_header_value("X-Request-Id");
  exchange.request.id = is_request_id(given_id) ? given_id : next_request_id();
  const std::string traceparent = raw.get_header_value("traceparent");
  if (is_traceparent(traceparent)) exchange.request.traceparent = traceparent;
  exchange.request.method = raw.method;

  Response response;
  try {
    response = answer(exchange);
    exchange.close |= is_left_unread(exchange);
  } catch (const std::exception& exception) {
    spdlog::error("{} {}", exchange.request.id, exception.what());
    response =
        problem_response(500, "internal", "The server's log has the details, by the request's id.");
    exchange.close = true;
  }

  const double ms = std::chrono::duration<double, std::milli>(SteadyClock::now() - begin).count();
  services.metrics->count_request(raw.method, exchange.route, response.status, ms / 1e3);
  log_request(exchange, response.status, ms);
  write(exchange, std::move(response), out);
}

Response HttpServer::Impl::answer(Exchange& exchange) {
  const httplib::Request& raw = exchange.raw;
  if (WorkerPool::is_shedding()) {
    services.metrics->count_shed("busy");
    return problem_response(503, "busy", "Too many requests are in work; try again.");
  }
  if (raw.target.size() > kMaxTargetLength) return uri_too_long();
  if (raw.ranges.size() > 1) {
    return problem_response(416, "range_not_satisfiable", "Ask for one range at most.");
  }
  return answer_by_route(exchange);
}

Response HttpServer::Impl::answer_by_route(Exchange& exchange) {
  const httplib::Request& raw = exchange.raw;
  Request& request = exchange.request;
  const auto path = split_path(raw.target);
  if (!path) return problem_response(404, "not_found", "There is no such path.");
  auto match = router.match(raw.method, *path);
  if (std::holds_alternative<NoRoute>(match)) return answer_by_file(exchange, *path);
  if (const auto* wrong = std::get_if<MethodNotAllowed>(&match)) {
    Response response =
        problem_response(405, "method_not_allowed", "The path takes " + wrong->allow + ".");
    response.headers.emplace_back("Allow", wrong->allow);
    return response;
  }
  auto& [route, captures] = std::get<RouteMatch>(match);
  exchange.route = route->pattern;
  if (auto refusal = refuse(exchange, route->access)) return *refusal;
  request.captures = std::move(captures);
  request.query = {raw.params.begin(), raw.params.end()};
  const AnswerFormat answer = best_format(raw.get_header_value("Accept"));
  request.answer_format = answer.body;
  request.answer_profile = answer.profile;
  request.if_none_match = raw.get_header_value("If-None-Match");
  if (may_have_body(raw.method)) {
    if (auto refusal = take_body(exchange, route->body, config.max_body_bytes)) return *refusal;
  }
  return route->handler(request);
}

Response HttpServer::Impl::answer_by_file(Exchange& exchange, const PathSegments& path) {
  const httplib::Request& raw = exchange.raw;
  const bool is_icon = path.size() == 1 && path[0] == "favicon.ico";
  const PathSegments file = is_icon ? PathSegments{"favicon.svg"} : path;
  if (!files.exists(file)) return problem_response(404, "not_found", "There is no such path.");
  exchange.route = "files";
  if (raw.method != "GET" && raw.method != "HEAD") {
    Response response = problem_response(405, "method_not_allowed", "The path takes GET, HEAD.");
    response.headers.emplace_back("Allow", "GET, HEAD");
    return response;
  }
  auto response = files.get(file, raw.get_header_value("If-None-Match"));
  return response ? *response : problem_response(404, "not_found", "There is no such path.");
}

std::optional<Response> HttpServer::Impl::refuse_foreign_page(const httplib::Request& raw) const {
  const std::string host = raw.get_header_value("Host");
  if (!host.empty() && !hosts.allows_host(host)) {
    return problem_response(421, "misdirected_request",
                            "Host " + host +
                                " is not known as a name of this server: configure tokens, or add "
                                "it to allowed_hosts.");
  }
  const auto [first, last] = raw.headers.equal_range("Origin");
  const bool is_foreign = std::any_of(
      first, last, [&](const auto& header) { return !hosts.allows_origin(header.second, host); });
  if (raw.method != "GET" && raw.method != "HEAD" && is_foreign) {
    return problem_response(403, "forbidden", "Another site's page may not change anything here.");
  }
  return std::nullopt;
}

std::optional<Response> HttpServer::Impl::refuse(Exchange& exchange, Access access) {
  const httplib::Request& raw = exchange.raw;
  if (raw.method != "GET" && raw.method != "HEAD" && is_cross_site(raw)) {
    return problem_response(403, "forbidden", "Another site's page may not change anything here.");
  }
  if (access == Access::kPublic) return std::nullopt;
  const auto known_tokens = current_tokens();
  if (known_tokens->is_empty()) {
    if (auto refusal = refuse_foreign_page(raw)) return refusal;
  }
  const auto principal = known_tokens->identify(raw.get_header_value("Authorization"), now_text());
  if (!principal) {
    Response response = problem_response(401, "unauthorized", "Send Authorization: Bearer TOKEN.");
    response.headers.emplace_back("WWW-Authenticate", "Bearer realm=\"cornerfix\"");
    return response;
  }
  if (!may(principal->role, access)) {
    return problem_response(403, "forbidden", "The token's role does not allow this.");
  }
  exchange.request.principal = *principal;
  return std::nullopt;
}

void HttpServer::Impl::write(Exchange& exchange, Response response, httplib::Response& out) {
  exchange.raw.ranges.clear();  // A whole answer to a range is allowed (RFC 9110, 14.2).
  if (exchange.close || *services.draining) {
    exchange.raw.headers.erase("Connection");
    exchange.raw.headers.emplace("Connection", "close");
  }
  add_common_headers(response, exchange.request.id);
  if (!exchange.request.traceparent.empty())
    response.headers.emplace_back("traceparent", exchange.request.traceparent);
  out.status = response.status;
  for (const auto& [name, value] : response.headers) out.set_header(name.c_str(), value);
  if (response.events) {
    out.set_chunked_content_provider(
        response.content_type, [events = response.events](std::size_t, httplib::DataSink& sink) {
          if (!sink.is_writable()) return false;
          const auto piece = events->next(kHeartbeat);
          if (piece) return sink.write(piece->data(), piece->size());
          sink.done();
          return false;
        });
    return;
  }
  if (!response.body.empty()) out.set_content(response.body, response.content_type);
}

Result<std::unique_ptr<HttpServer>> HttpServer::start(const ServerConfig& config) {
  auto impl = std::make_unique<Impl>(config);
  // The port first: where it is taken, no new database is left behind.
  auto listener = ListenSocket::open(config.listen, config.port);
  if (!listener) return listener.error();
  impl->port = listener->port();
  if (auto opened = impl->open_services(); !opened) return opened.error();
  const auto tokens = impl->current_tokens();
  if (!tokens) return Error{ErrorCode::kUnavailable, "the tokens cannot be read", ""};
  if (auto error = check_listen(config, tokens->is_empty())) return *error;
  impl->set_up_http();
  impl->open_connections(std::move(*listener));
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HttpServer::~HttpServer() = default;

int HttpServer::port() const { return impl_->port; }

bool HttpServer::run() {
  const bool was_drained = impl_->connections->run();
  impl_->workers->shutdown();
  return was_drained;
}

void HttpServer::set_tokens(std::vector<Token> tokens) {
  {
    const std::lock_guard lock(impl_->tokens_mutex);
    impl_->config.tokens = std::move(tokens);
    impl_->tokens_epoch = 0;  // Epochs of the store begin at 1.
  }
  (void)impl_->current_tokens();
}

void HttpServer::drain() {
  *impl_->services.draining = true;
  impl_->services.events->close();
  impl_->services.reports->close();
  impl_->connections->drain();
}

}  // namespace cornerfix::server
