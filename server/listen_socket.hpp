/// \file  The socket on which the server takes connections.
#pragma once

#include <string>

#include <cornerfix/result.hpp>

namespace cornerfix::server {

/// Owns its descriptor.
class ListenSocket {
 public:
  /// Binds `address`, a name or an IP address, and `port`, 0 for a free one. kUnavailable when that
  /// fails. Does not share its port with another server.
  [[nodiscard]] static Result<ListenSocket> open(const std::string& address, int port);

  ~ListenSocket() { close(); }
  ListenSocket(ListenSocket&& other) noexcept;
  ListenSocket& operator=(ListenSocket&& other) noexcept;

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] int port() const { return port_; }
  /// Takes no more connections.
  void close();

 private:
  ListenSocket(int descriptor, int port) : descriptor_(descriptor), port_(port) {}

  int descriptor_ = -1;
  int port_ = 0;
};

}  // namespace cornerfix::server
