/// \file  All connections of the server, held by one thread.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include <cornerfix/result.hpp>

#include "server/connection.hpp"
#include "server/listen_socket.hpp"

namespace cornerfix::server {

struct ConnectionLimits {
  std::size_t connections = 16'000;
  std::size_t connections_per_address = 12'000;
  std::size_t held_body = kMaxBufferedBody;              ///< A larger one is read by a worker.
  std::size_t streamed_requests = 16;                    ///< Bodies that workers read themselves.
  std::size_t buffered_bytes = std::size_t{256} << 20U;  ///< Of all requests and answers.
  std::chrono::milliseconds idle_timeout{60'000};        ///< Until the next request begins.
  std::chrono::milliseconds head_timeout{5'000};         ///< From its first byte to its head's end.
  std::chrono::milliseconds drain_timeout{5'000};        ///< From drain() until all are closed.
};

/// Connections that wait for a request, for the rest of one, or for a client to read its answer.
class ConnectionLoop {
 public:
  /// Hands a request to a worker, who gives it back with finish(). False when there are too many
  /// requests in work: the request is left as it is.
  using Dispatch = std::function<bool(const RequestInWorkPtr&)>;
  /// Renders the answer to a request that no worker sees.
  using Refuse = std::function<std::string(const Refusal&)>;

  ConnectionLoop(ListenSocket listener, ConnectionLimits limits, Dispatch dispatch, Refuse refuse);
  ~ConnectionLoop();
  ConnectionLoop(const ConnectionLoop&) = delete;
  ConnectionLoop& operator=(const ConnectionLoop&) = delete;

  /// Serves until drain() is called and all connections are closed, or until the drain time is
  /// over. False when the operating system refuses to wait.
  [[nodiscard]] bool run();

  /// Takes no new connection; answers what was sent and closes each connection after it. Any thread
  /// may call.
  void drain();

  /// `unsent` is the rest of the answer. The connection closes after it unless it `is_kept`. Any
  /// thread may call, also when run() has returned.
  void finish(RequestInWorkPtr request, std::string unsent, bool is_kept);

  /// Open connections. Any thread may call.
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  using Clock = Connection::Clock;
  struct Finished {
    RequestInWorkPtr request;
    std::string unsent;
    bool is_kept;
  };

  void wake();
  void serve_event(int descriptor);
  void accept_all();
  void add(int socket);
  void turn_away(int socket);
  void take_finished();
  void begin_draining();
  void close_overdue();
  void cut_off_work();
  [[nodiscard]] bool is_done() const;
  [[nodiscard]] int milliseconds_to_wait() const;

  void receive(Connection& connection);
  void take(Connection& connection, std::string_view bytes);
  void wait_for_body(Connection& connection);
  [[nodiscard]] bool make_room(Connection& newest);
  [[nodiscard]] Connection& slowest_sender(Connection& newest);
  void dispatch(Connection& connection);
  void refuse(Connection& connection, const Refusal& refusal);
  void send(Connection& connection, std::string text, bool is_kept);
  void send_rest(Connection& connection);
  void next_request(Connection& connection);
  void linger(Connection& connection);
  void drop_input(Connection& connection);
  void close(Connection& connection);

  void wait_for(Connection& connection, unsigned events, Clock::time_point deadline);
  void set_deadline(Connection& connection, Clock::time_point deadline);
  void count_buffered(Connection& connection);

  ListenSocket listener_;
  ConnectionLimits limits_;
  Dispatch dispatch_;
  Refuse refuse_;
  int epoll_ = -1;
  int wake_ = -1;
  std::unordered_map<int, std::unique_ptr<Connection>> connections_;  ///< By socket.
  std::set<std::pair<Clock::time_point, int>> deadlines_;
  std::map<std::string, std::size_t> per_address_;
  std::size_t streamed_ = 0;
  std::size_t buffered_bytes_ = 0;
  std::array<char, std::size_t{64} << 10U> buffer_{};
  std::atomic<std::size_t> count_ = 0;
  std::atomic<bool> is_drain_asked_ = false;
  bool is_draining_ = false;
  bool is_accepting_ = true;
  Clock::time_point drain_deadline_{};
  Clock::time_point accept_again_{};  ///< After descriptors ran out.
  std::mutex mutex_;
  std::vector<Finished> finished_;
};

}  // namespace cornerfix::server
