#include "server/socket_io.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace cornerfix::server {
namespace {

using Milliseconds = std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;
using GetName = int (*)(int, sockaddr*, socklen_t*);

SocketName name_of(int socket, GetName get_name) {
  sockaddr_storage name{};
  socklen_t size = sizeof name;
  if (get_name(socket, reinterpret_cast<sockaddr*>(&name), &size) != 0) return {};
  std::array<char, INET6_ADDRSTRLEN> text{};
  int port = 0;
  if (name.ss_family == AF_INET) {
    const auto& ipv4 = reinterpret_cast<const sockaddr_in&>(name);
    inet_ntop(AF_INET, &ipv4.sin_addr, text.data(), text.size());
    port = ntohs(ipv4.sin_port);
  } else if (name.ss_family == AF_INET6) {
    const auto& ipv6 = reinterpret_cast<const sockaddr_in6&>(name);
    inet_ntop(AF_INET6, &ipv6.sin6_addr, text.data(), text.size());
    port = ntohs(ipv6.sin6_port);
  }
  return {text.data(), port};
}

}  // namespace

bool wait_for(int socket, short events, Milliseconds timeout) {
  const auto deadline = SteadyClock::now() + timeout;
  pollfd entry{.fd = socket, .events = events, .revents = 0};
  for (;;) {
    const auto left = std::chrono::ceil<Milliseconds>(deadline - SteadyClock::now());
    const int ready = ::poll(&entry, 1, static_cast<int>(std::max<long>(0, left.count())));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

ssize_t receive_now(int socket, char* to, std::size_t size) {
  ssize_t received = 0;
  do {
    received = ::recv(socket, to, size, MSG_DONTWAIT);
  } while (received < 0 && errno == EINTR);
  return received;
}

ssize_t send_now(int socket, const char* from, std::size_t size) {
  ssize_t sent = 0;
  do {
    sent = ::send(socket, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  return sent;
}

SocketName local_name(int socket) { return name_of(socket, ::getsockname); }
SocketName remote_name(int socket) { return name_of(socket, ::getpeername); }

}  // namespace cornerfix::server
