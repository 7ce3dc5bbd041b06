/// \file  What connections need of their sockets.
#pragma once

#include <sys/types.h>
#include <chrono>
#include <cstddef>
#include <string>

namespace cornerfix::server {

/// Whether the socket is ready for `events` (as of poll), or broken, in time.
[[nodiscard]] bool wait_for(int socket, short events, std::chrono::milliseconds timeout);

/// Bytes received or sent without waiting; 0: the client has closed; below 0: errno says why.
[[nodiscard]] ssize_t receive_now(int socket, char* to, std::size_t size);
[[nodiscard]] ssize_t send_now(int socket, const char* from, std::size_t size);

struct SocketName {
  std::string ip;
  int port = 0;
};
/// Empty when the socket has none.
[[nodiscard]] SocketName local_name(int socket);
[[nodiscard]] SocketName remote_name(int socket);

}  // namespace cornerfix::server
