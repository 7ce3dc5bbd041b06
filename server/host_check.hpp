/// \file  Whether a request was meant for this server: protection from DNS rebinding.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cornerfix::server {

/// Without tokens strangers can reach the server through a browser. A page of theirs has its name
/// resolved to this machine, and asks the server as if it were the page's own. Such a request has
/// the page's name in its Host header. Immutable, so any threads may share it.
class HostCheck {
 public:
  /// \param listen  The address that the server is bound to.
  /// \param allowed_hosts  Further names of the server, without ports.
  HostCheck(const std::string& listen, std::vector<std::string> allowed_hosts);

  /// Whether a Host header names this server. A server on loopback has loopback's names and
  /// addresses. One on other addresses also has any address, and names that no public DNS has:
  /// those without a dot, and those in .local.
  [[nodiscard]] bool allows_host(std::string_view host) const;
  /// Whether an Origin header is that of the server's own pages, or of an allowed host's.
  [[nodiscard]] bool allows_origin(std::string_view origin, std::string_view host) const;

 private:
  std::string listen_;
  std::vector<std::string> allowed_hosts_;
};

}  // namespace cornerfix::server
