/// \file  The calls of the API on a database of its own: routes and services without a socket.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "server/routes.hpp"
#include "server/server_config.hpp"
#include "server/service_setup.hpp"

namespace cornerfix::fuzz {

inline void require(bool condition) {
  if (!condition) std::abort();
}

/// A call as a route sees it, after its body was read.
struct Call {
  std::string method;
  std::string path;  ///< Without a query.
  std::multimap<std::string, std::string> query{};
  std::string body{};
  std::map<std::string, std::string> parts{};
};

/// A process that serves a database file. Ends as a server does after SIGTERM.
class ApiUnderTest {
 public:
  explicit ApiUnderTest(const server::ServerConfig& config) {
    auto opened = server::open_services(config, [] { return server::ServerLoad{}; });
    if (!opened) throw std::runtime_error(opened.error().message);
    services_ = std::move(*opened);
    router_ = server::make_router(services_);
  }
  ~ApiUnderTest() {
    services_.events->close();
    services_.reports->close();
    services_.jobs->close();
    require(services_.localization->store_all() == 0);
  }
  ApiUnderTest(const ApiUnderTest&) = delete;
  ApiUnderTest& operator=(const ApiUnderTest&) = delete;

  /// No call fails in the server, and what is said to be JSON is JSON. A report is made beside the
  /// calls, so it may have to be asked for again.
  server::Response answer(const Call& call) {
    server::Response response = dispatch(call);
    const bool is_report = call.path.ends_with("/report");
    require(response.status < 500 || (response.status == 503 && is_report));
    const bool is_json = response.content_type.find("json") != std::string::npos;
    require(!is_json || response.body.empty() || nlohmann::json::accept(response.body));
    return response;
  }

 private:
  server::Response dispatch(const Call& call) {
    const auto path = server::split_path(call.path);
    if (!path) return server::problem_response(404, "not_found", "No such path.");
    auto match = router_.match(call.method, *path);
    auto* found = std::get_if<server::RouteMatch>(&match);
    if (found == nullptr) return server::problem_response(404, "not_found", "No such path.");
    if (const auto problem = server::check_query(*found->route, call.query)) {
      return server::problem_response(*problem);
    }
    server::Request request;
    request.id = "fuzz";
    request.method = call.method;
    request.captures = std::move(found->captures);
    request.query = call.query;
    request.body = call.body;
    request.parts = call.parts;
    const bool is_optional = found->route->body == server::BodyRule::kOptionalDocument;
    if (is_optional && request.body.empty()) request.body = "{}";
    return found->route->handler(request);
  }

  server::Services services_;
  server::Router router_;
};

}  // namespace cornerfix::fuzz
