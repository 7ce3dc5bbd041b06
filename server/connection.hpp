/// \file  One connection: request after request, until one side closes it.
///
/// The HTTP library has a reader of its own, but it polls, and it reads heads without a bound and
/// bodies whose end is in doubt.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "server/request_receiver.hpp"

namespace cornerfix::server {

struct ConnectionTimeouts {
  std::chrono::milliseconds request;  ///< Until the next request begins.
  std::chrono::milliseconds head;     ///< From its first byte to the end of its head.
};

/// Owns its socket, and keeps what was received of the next request. One thread at a time.
class Connection {
 public:
  Connection(int socket, ConnectionTimeouts timeouts) : socket_(socket), timeouts_(timeouts) {}
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Waits for a request and its head. False when none comes in time, the client has closed the
  /// connection, or the head is refused: refusal() is set then, if the client waits for an answer.
  [[nodiscard]] bool receive_head();
  [[nodiscard]] const std::optional<Refusal>& refusal() const { return refusal_; }

  /// Sends the last answer, and lets the client read it before the socket closes.
  void send_last(std::string_view answer);
  /// Waits, for a short time, until the client has read what was sent.
  void linger();

  [[nodiscard]] int socket() const { return socket_; }
  [[nodiscard]] RequestReceiver& receiver() { return receiver_; }
  [[nodiscard]] std::string& input() { return input_; }

 private:
  int socket_;
  ConnectionTimeouts timeouts_;
  RequestReceiver receiver_;
  std::string input_;  ///< Received, and not yet part of a request.
  std::optional<Refusal> refusal_;
};

}  // namespace cornerfix::server
