#include "server/host_check.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "server/server_config.hpp"

namespace cornerfix::server {
namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return lower;
}

/// "Name:80" as "name", "[::1]:80" as "::1".
std::string name_of(std::string_view host) {
  if (host.starts_with('[')) return lower_case(host.substr(1, host.find(']') - 1));
  std::string_view name = host.substr(0, host.find(':'));
  if (name.ends_with('.')) name.remove_suffix(1);
  return lower_case(name);
}

bool is_address(const std::string& name) {
  in6_addr address{};
  return inet_pton(AF_INET, name.c_str(), &address) == 1 ||
         inet_pton(AF_INET6, name.c_str(), &address) == 1;
}

bool is_loopback_name(const std::string& name) {
  return name == "localhost" || name.ends_with(".localhost") ||
         (is_address(name) && is_loopback(name));
}

bool is_local_name(const std::string& name) {
  return name.find('.') == std::string::npos || name.ends_with(".local");
}

}  // namespace

HostCheck::HostCheck(const std::string& listen, std::vector<std::string> allowed_hosts)
    : listen_(lower_case(listen)), allowed_hosts_(std::move(allowed_hosts)) {
  for (std::string& host : allowed_hosts_) host = lower_case(host);
}

bool HostCheck::allows_host(std::string_view host) const {
  const std::string name = name_of(host);
  if (name.empty()) return false;
  if (is_loopback_name(name) || name == listen_) return true;
  if (std::ranges::find(allowed_hosts_, name) != allowed_hosts_.end()) return true;
  return !is_loopback(listen_) && (is_address(name) || is_local_name(name));
}

bool HostCheck::allows_origin(std::string_view origin, std::string_view host) const {
  const auto scheme_end = origin.find("://");
  if (scheme_end == std::string_view::npos) return false;  // "null", say.
  const std::string_view origin_host = origin.substr(scheme_end + 3);
  if (lower_case(origin_host) == lower_case(host)) return true;
  return std::ranges::find(allowed_hosts_, name_of(origin_host)) != allowed_hosts_.end();
}

}  // namespace cornerfix::server
