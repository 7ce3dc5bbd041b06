/// \file  One connection as the event loop holds it, and one request on its way through a worker.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include "server/request_receiver.hpp"
#include "server/socket_io.hpp"
#include "server/transfer_pace.hpp"

namespace cornerfix::server {

/// A body up to this size is read to its end even when it is refused, so that the connection stays.
inline constexpr std::size_t kMaxBufferedBody = std::size_t{1} << 20U;

/// A request whose head has arrived, with its body as far as it was received. A worker has it for
/// itself; the event loop does not touch the socket until the request comes back.
struct RequestInWork {
  int socket = -1;
  SocketName client;
  RequestReceiver receiver;
  std::string input;  ///< Received after the request.

  /// Whether the worker reads the rest of the body from the socket.
  [[nodiscard]] bool is_streamed() const {
    return receiver.state() != RequestReceiver::State::kComplete;
  }
};
using RequestInWorkPtr = std::shared_ptr<RequestInWork>;

/// Owns its socket.
struct Connection {
  using Clock = std::chrono::steady_clock;
  enum class State {
    kIdle,       ///< No byte of the next request has arrived.
    kReceiving,  ///< Its head or its body is arriving.
    kInWork,     ///< A worker has it.
    kSending,    ///< The rest of the answer is being sent.
    kLingering,  ///< All is sent; the client reads it before the socket closes.
  };

  Connection(int the_socket, SocketName the_client);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  int socket;
  SocketName client;
  State state = State::kIdle;
  RequestReceiver receiver{};
  std::string input{};   ///< Received and not yet part of a request.
  std::string output{};  ///< To be sent from `sent` on.
  std::size_t sent = 0;
  bool is_kept = true;           ///< Takes another request after this one.
  bool is_body_awaited = false;  ///< Its head is complete, its body is not.
  bool is_streamed = false;      ///< Its request in work is.
  std::size_t buffered = 0;      ///< Bytes that count in the loop's budget.
  TransferPace pace{{}};         ///< Of the body, the answer, or what is dropped.
  Clock::time_point deadline{};  ///< Closes then, when set.
};

}  // namespace cornerfix::server
