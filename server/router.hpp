/// \file  One small table of routes that knows 404 from 405.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "server/access.hpp"
#include "server/http_message.hpp"

namespace cornerfix::server {

/// What a route does with a request body.
enum class BodyRule {
  kIgnored,           ///< Read and dropped: none is needed.
  kDocument,          ///< JSON, CBOR or MessagePack.
  kScanBatch,         ///< The same, or the binary batch of a session.
  kRun,               ///< The same, and as large as a form when it is to be a job.
  kOptionalDocument,  ///< The same, or none, which is an empty object.
  kArchive,           ///< Bytes of a map's archive.
  kForm,              ///< multipart/form-data, in Request::parts.
};

struct Route {
  std::string method;
  std::string pattern;  ///< "/v1/maps/{map}": a segment in braces matches any non-empty one.
  Access access = Access::kRead;
  BodyRule body = BodyRule::kIgnored;
  Handler handler;
  std::vector<std::string> parameters{};  ///< Of the query, that it takes.
};

/// The parameters of a target's query, decoded. Those that are there twice are kept twice, also
/// when their values are equal.
[[nodiscard]] std::multimap<std::string, std::string> parse_query(std::string_view target);

/// What is wrong with a query: a parameter that the route does not take, or one that is there
/// twice.
[[nodiscard]] std::optional<api::Problem> check_query(
    const Route& route, const std::multimap<std::string, std::string>& query);

/// A path cut at its slashes, each segment percent-decoded once.
using PathSegments = std::vector<std::string>;

/// Decodes the path of a request target (origin or absolute form, without its query), or nothing
/// when an escape is broken.
[[nodiscard]] std::optional<PathSegments> split_path(std::string_view target);

struct RouteMatch {
  const Route* route = nullptr;
  std::vector<std::string> captures;
};
struct MethodNotAllowed {
  std::string allow;  ///< For the Allow header.
};
struct NoRoute {};

/// Filled before the first request, then only read, by any threads.
class Router {
 public:
  void add(Route route);

  /// A HEAD is served by the route of GET.
  [[nodiscard]] std::variant<RouteMatch, MethodNotAllowed, NoRoute> match(
      std::string_view method, const PathSegments& path) const;

 private:
  struct Entry {
    Route route;
    PathSegments pattern;
  };
  std::vector<Entry> entries_;
};

/// Adds routes whose handlers are member functions of `routes`: add(method, pattern, access, body,
/// handler, parameters).
template <typename Routes>
[[nodiscard]] auto adder_of(Router& router, std::shared_ptr<Routes> routes) {
  return [&router, routes = std::move(routes)](const char* method, const char* pattern,
                                               Access access, BodyRule body,
                                               Response (Routes::*handler)(const Request&),
                                               const std::vector<std::string>& parameters = {}) {
    router.add({.method = method,
                .pattern = pattern,
                .access = access,
                .body = body,
                .handler = [routes, handler](
                               const Request& request) { return ((*routes).*handler)(request); },
                .parameters = parameters});
  };
}

}  // namespace cornerfix::server
