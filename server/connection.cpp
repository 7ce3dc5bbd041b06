#include "server/connection.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>

// After all else: its <resolv.h> defines macros.
#include <httplib.h>

namespace cornerfix::server {
namespace {

using Milliseconds = std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

/// Whether the socket is ready for `events`, or broken, in time.
bool wait_for(int socket, short events, Milliseconds timeout) {
  const auto deadline = SteadyClock::now() + timeout;
  pollfd entry{.fd = socket, .events = events, .revents = 0};
  for (;;) {
    const auto left = std::chrono::ceil<Milliseconds>(deadline - SteadyClock::now());
    const int ready = ::poll(&entry, 1, static_cast<int>(std::max<long>(0, left.count())));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

using GetName = int (*)(int, sockaddr*, socklen_t*);

/// Leaves `ip` and `port` as they are when the socket has no name.
void read_name(int socket, GetName get_name, std::string& ip, int& port) {
  sockaddr_storage name{};
  socklen_t size = sizeof name;
  if (get_name(socket, reinterpret_cast<sockaddr*>(&name), &size) != 0) return;
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (name.ss_family == AF_INET) {
    const auto& ipv4 = reinterpret_cast<const sockaddr_in&>(name);
    inet_ntop(AF_INET, &ipv4.sin_addr, text.data(), text.size());
    port = ntohs(ipv4.sin_port);
  } else if (name.ss_family == AF_INET6) {
    const auto& ipv6 = reinterpret_cast<const sockaddr_in6&>(name);
    inet_ntop(AF_INET6, &ipv6.sin6_addr, text.data(), text.size());
    port = ntohs(ipv6.sin6_port);
  }
  ip = text.data();
}

}  // namespace

class Connection::SocketStream final : public httplib::Stream {
 public:
  SocketStream(int socket, ConnectionTimeouts timeouts) : socket_(socket), timeouts_(timeouts) {}
  ~SocketStream() override {
    ::shutdown(socket_, SHUT_RDWR);
    ::close(socket_);
  }
  SocketStream(const SocketStream&) = delete;
  SocketStream& operator=(const SocketStream&) = delete;

  [[nodiscard]] bool wait_for_request() const {
    return begin_ < end_ || wait_for(socket_, POLLIN, timeouts_.request);
  }

  [[nodiscard]] bool is_readable() const override {
    return begin_ < end_ || wait_for(socket_, POLLIN, timeouts_.read);
  }
  [[nodiscard]] bool is_writable() const override {
    return wait_for(socket_, POLLOUT, timeouts_.write);
  }

  /// The library reads lines byte by byte, so small reads are served from a buffer.
  ssize_t read(char* to, std::size_t size) override {
    if (begin_ == end_) {
      if (size >= buffer_.size()) return receive(to, size);
      const ssize_t received = receive(buffer_.data(), buffer_.size());
      if (received <= 0) return received;
      begin_ = 0;
      end_ = static_cast<std::size_t>(received);
    }
    const std::size_t taken = std::min(size, end_ - begin_);
    std::memcpy(to, buffer_.data() + begin_, taken);
    begin_ += taken;
    return static_cast<ssize_t>(taken);
  }

  ssize_t write(const char* from, std::size_t size) override {
    if (!is_writable()) return -1;
    ssize_t sent = 0;
    do {
      sent = ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    } while (sent < 0 && errno == EINTR);
    return sent;
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    read_name(socket_, ::getpeername, ip, port);
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    read_name(socket_, ::getsockname, ip, port);
  }
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  ssize_t receive(char* to, std::size_t size) const {
    if (!wait_for(socket_, POLLIN, timeouts_.read)) return -1;
    ssize_t received = 0;
    do {
      received = ::recv(socket_, to, size, 0);
    } while (received < 0 && errno == EINTR);
    return received;
  }

  int socket_;
  ConnectionTimeouts timeouts_;
  std::array<char, 4096> buffer_{};  ///< What was received and not yet read: [begin_, end_).
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
};

Connection::Connection(int socket, ConnectionTimeouts timeouts)
    : stream_(std::make_unique<SocketStream>(socket, timeouts)) {}
Connection::~Connection() = default;

bool Connection::wait_for_request() { return stream_->wait_for_request(); }

httplib::Stream& Connection::stream() { return *stream_; }

}  // namespace cornerfix::server
