#include "server/http_server.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/access_gate.hpp"
#include "server/connection_loop.hpp"
#include "server/event_log.hpp"
#include "server/exchange_log.hpp"
#include "server/http_message.hpp"
#include "server/listen_socket.hpp"
#include "server/media_types.hpp"
#include "server/preference.hpp"
#include "server/request_body.hpp"
#include "server/request_stream.hpp"
#include "server/request_trace.hpp"
#include "server/responses.hpp"
#include "server/router.hpp"
#include "server/routes.hpp"
#include "server/service_setup.hpp"
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
constexpr std::size_t kMaxHeldBody = std::size_t{64} << 20U;
constexpr std::size_t kStreamedRequests = 16;      // Archives, and bodies that are too large.
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

std::string random_prefix() {
  std::random_device random;
  return fmt::format("{:08x}", random());
}

bool may_have_body(std::string_view method) {
  return method == "POST" || method == "PUT" || method == "PATCH" || method == "DELETE";
}

Caller caller_of(const httplib::Request& raw) {
  const auto [first, last] = raw.headers.equal_range("Origin");
  Caller caller{.address = raw.remote_addr,
                .is_reading = raw.method == "GET" || raw.method == "HEAD",
                .authorization = raw.get_header_value("Authorization"),
                .host = raw.get_header_value("Host"),
                .fetch_site = raw.get_header_value("Sec-Fetch-Site")};
  std::for_each(first, last, [&](const auto& header) { caller.origins.push_back(header.second); });
  return caller;
}

Preference preference_of(const httplib::Request& raw) {
  Preference preference;
  const auto [first, last] = raw.headers.equal_range("Prefer");
  std::for_each(first, last, [&](const auto& line) { add_preference(preference, line.second); });
  return preference;
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
  explicit Impl(ServerConfig the_config) : config(std::move(the_config)) {}

  ServerConfig config;
  Services services;
  std::optional<AccessGate> gate;
  Router router;
  StaticFiles files;
  std::string id_prefix = random_prefix();
  std::atomic<std::uint64_t> next_id{1};
  std::atomic<std::size_t> in_work{0};
  int port = 0;
  LibraryServer http;
  std::optional<ConnectionLoop> connections;
  std::optional<WorkerPool> workers;  ///< Ends first: its jobs use all of the above.

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
  std::string next_request_id() { return id_prefix + "-" + std::to_string(next_id++); }
  Response answer(Exchange& exchange);
  Response answer_by_route(Exchange& exchange);
  Response answer_by_file(Exchange& exchange, const PathSegments& path);
  void write(Exchange& exchange, Response response, httplib::Response& out);
};

Result<void> HttpServer::Impl::open_services() {
  auto opened = server::open_services(config, [this] { return load(); });
  if (!opened) return opened.error();
  services = std::move(*opened);
  gate.emplace(config, services.stores, services.metrics, now_text);
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
                       .held_body = std::min(config.max_body_bytes, kMaxHeldBody),
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

void HttpServer::Impl::refuse_unread(const httplib::Request& raw, httplib::Response& out) {
  Exchange exchange{.raw = const_cast<httplib::Request&>(raw), .reader = nullptr};
  exchange.close = true;
  exchange.request.id = next_request_id();
  Response response = problem_response(out.status, "malformed", "The request cannot be read.");
  log_exchange(exchange, response.status, 0.0);
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
  log_exchange(exchange, response.status, ms);
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
  auto admitted = gate->admit(caller_of(raw), route->access);
  if (auto* refusal = std::get_if<Response>(&admitted)) return std::move(*refusal);
  request.principal = std::move(std::get<Principal>(admitted));
  request.captures = std::move(captures);
  request.query = parse_query(raw.target);
  // Health checks of others may carry a query.
  if (route->access != Access::kPublic) {
    if (const auto problem = check_query(*route, request.query)) return problem_response(*problem);
  }
  const AnswerFormat answer = best_format(raw.get_header_value("Accept"));
  request.answer_format = answer.body;
  request.answer_profile = answer.profile;
  request.if_none_match = raw.get_header_value("If-None-Match");
  if (raw.has_header("If-Match")) request.if_match = raw.get_header_value("If-Match");
  request.preference = preference_of(raw);
  if (may_have_body(raw.method)) {
    const bool may_be_long = route->body == BodyRule::kRun && request.preference.respond_async;
    const std::size_t limit =
        may_be_long ? std::max(kMaxRunBytes, config.max_body_bytes) : config.max_body_bytes;
    if (auto refusal = take_body(exchange, route->body, limit)) return *refusal;
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
  const auto tokens = impl->gate->tokens();
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

std::size_t HttpServer::store_sessions() { return impl_->services.localization->store_all(); }

void HttpServer::set_tokens(std::vector<Token> tokens) {
  impl_->gate->set_tokens(std::move(tokens));
}

void HttpServer::drain() {
  *impl_->services.draining = true;
  impl_->services.events->close();
  impl_->services.reports->close();
  impl_->services.jobs->close();
  impl_->connections->drain();
}

}  // namespace cornerfix::server
