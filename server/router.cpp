#include "server/router.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

namespace cornerfix::server {
namespace {

std::optional<std::string> percent_decode(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    unsigned char byte = 0;
    if (i + 2 >= text.size()) return std::nullopt;
    const char* const digits = text.data() + i + 1;
    const auto [end, error] = std::from_chars(digits, digits + 2, byte, 16);
    if (error != std::errc{} || end != digits + 2) return std::nullopt;
    decoded += static_cast<char>(byte);
    i += 2;
  }
  return decoded;
}

/// As a form writes it, with + for a blank; as it is where an escape is wrong.
std::string query_decode(std::string_view text) {
  std::string blank_text(text);
  std::ranges::replace(blank_text, '+', ' ');
  return percent_decode(blank_text).value_or(std::string(text));
}

/// The path of "http://host/path", which a server must take like "/path" (RFC 9112, 3.2.2).
std::string_view path_of(std::string_view target) {
  target = target.substr(0, target.find_first_of("?#"));
  if (target.starts_with('/')) return target;
  const auto authority = target.find("://");
  if (authority == std::string_view::npos) return target;
  const auto slash = target.find('/', authority + 3);
  return slash == std::string_view::npos ? "/" : target.substr(slash);
}

bool is_capture(std::string_view segment) { return segment.starts_with('{'); }

std::optional<std::vector<std::string>> captures_of(const PathSegments& pattern,
                                                    const PathSegments& path) {
  if (pattern.size() != path.size()) return std::nullopt;
  std::vector<std::string> captures;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (is_capture(pattern[i])) {
      if (path[i].empty()) return std::nullopt;
      captures.push_back(path[i]);
    } else if (pattern[i] != path[i]) {
      return std::nullopt;
    }
  }
  return captures;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

}  // namespace

std::optional<PathSegments> split_path(std::string_view target) {
  std::string_view path = path_of(target);
  if (!path.starts_with('/')) return std::nullopt;
  PathSegments segments;
  do {
    path.remove_prefix(1);
    auto segment = percent_decode(path.substr(0, path.find('/')));
    if (!segment) return std::nullopt;
    segments.push_back(std::move(*segment));
    const auto slash = path.find('/');
    path = slash == std::string_view::npos ? std::string_view{} : path.substr(slash);
  } while (!path.empty());
  return segments;
}

std::multimap<std::string, std::string> parse_query(std::string_view target) {
  target = target.substr(0, target.find('#'));
  const auto question = target.find('?');
  std::string_view rest =
      question == std::string_view::npos ? std::string_view{} : target.substr(question + 1);
  std::multimap<std::string, std::string> query;
  while (!rest.empty()) {
    const std::string_view part = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    if (part.empty()) continue;
    const auto equals = part.find('=');
    const bool has_value = equals != std::string_view::npos;
    query.emplace(query_decode(part.substr(0, equals)),
                  has_value ? query_decode(part.substr(equals + 1)) : std::string{});
  }
  return query;
}

std::optional<api::Problem> check_query(const Route& route,
                                        const std::multimap<std::string, std::string>& query) {
  api::FieldErrors errors;
  for (auto one = query.begin(); one != query.end(); one = query.upper_bound(one->first)) {
    const std::string& name = one->first;
    const bool is_known = std::ranges::find(route.parameters, name) != route.parameters.end();
    if (!is_known) {
      errors.add("/" + name, "unknown query parameter, expected " + listed(route.parameters));
    } else if (query.count(name) > 1) {
      errors.add("/" + name, "is there twice");
    }
  }
  if (errors.empty()) return std::nullopt;
  return std::move(errors).to_problem();
}

void Router::add(Route route) {
  PathSegments pattern = split_path(route.pattern).value();
  entries_.push_back({std::move(route), std::move(pattern)});
}

std::variant<RouteMatch, MethodNotAllowed, NoRoute> Router::match(std::string_view method,
                                                                  const PathSegments& path) const {
  const std::string_view wanted = method == "HEAD" ? "GET" : method;
  std::string allow;
  for (const Entry& entry : entries_) {
    auto captures = captures_of(entry.pattern, path);
    if (!captures) continue;
    if (entry.route.method == wanted) return RouteMatch{&entry.route, std::move(*captures)};
    allow += (allow.empty() ? "" : ", ") + entry.route.method;
    if (entry.route.method == "GET") allow += ", HEAD";
  }
  if (allow.empty()) return NoRoute{};
  return MethodNotAllowed{std::move(allow)};
}

}  // namespace cornerfix::server
