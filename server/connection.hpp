/// \file  The bytes of one connection, for the HTTP library.
///
/// The library has a stream of its own, but polls: with it every robot that keeps its connection
/// wakes a thread about a hundred times a second, a third of what serving 200 robots costs.
#pragma once

#include <chrono>
#include <memory>

namespace httplib {  // NOLINT(readability-identifier-naming): the library's own name.
class Stream;
}  // namespace httplib

namespace cornerfix::server {

struct ConnectionTimeouts {
  std::chrono::milliseconds request;  ///< Until the next request begins.
  std::chrono::milliseconds read;     ///< For the next bytes of a request.
  std::chrono::milliseconds write;    ///< For the client to take the next bytes of an answer.
};

/// Owns its socket, and keeps what was read of the next request. One thread at a time.
class Connection {
 public:
  Connection(int socket, ConnectionTimeouts timeouts);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Waits, without waking up, until a request begins. False when none does in time; true also when
  /// the client has closed the connection, which reading will tell.
  [[nodiscard]] bool wait_for_request();

  [[nodiscard]] httplib::Stream& stream();

 private:
  class SocketStream;
  std::unique_ptr<SocketStream> stream_;
};

}  // namespace cornerfix::server
