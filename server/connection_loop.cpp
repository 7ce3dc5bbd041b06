#include "server/connection_loop.hpp"

#include <spdlog/spdlog.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <limits>
#include <system_error>

namespace cornerfix::server {
namespace {

using Milliseconds = std::chrono::milliseconds;
using std::chrono_literals::operator""s;

constexpr int kEventsAtOnce = 256;
constexpr int kAcceptsAtOnce = 1024;
constexpr Milliseconds kAcceptPause{100};
constexpr Milliseconds kDrainGrace{500};  // For what is on its way to a connection.
constexpr std::size_t kMaxDroppedBytes = std::size_t{64} << 20U;

constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";

int checked(int descriptor) {
  if (descriptor < 0) throw std::system_error(errno, std::generic_category(), "epoll");
  return descriptor;
}

void watch(int epoll, int operation, int descriptor, unsigned events) {
  epoll_event event{};
  event.events = events;
  event.data.fd = descriptor;
  ::epoll_ctl(epoll, operation, descriptor, &event);
}

/// Gives the memory back, which an assignment does not.
void release(std::string& text) { std::string().swap(text); }

bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK; }

}  // namespace

ConnectionLoop::ConnectionLoop(ListenSocket listener, ConnectionLimits limits, Dispatch dispatch,
                               Refuse refuse)
    : listener_(std::move(listener)),
      limits_(limits),
      dispatch_(std::move(dispatch)),
      refuse_(std::move(refuse)),
      epoll_(checked(::epoll_create1(EPOLL_CLOEXEC))),
      wake_(checked(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC))) {
  watch(epoll_, EPOLL_CTL_ADD, listener_.descriptor(), EPOLLIN);
  watch(epoll_, EPOLL_CTL_ADD, wake_, EPOLLIN);
}

ConnectionLoop::~ConnectionLoop() {
  ::close(epoll_);
  ::close(wake_);
}

bool ConnectionLoop::run() {
  std::array<epoll_event, kEventsAtOnce> events{};
  while (!is_done()) {
    const int ready = ::epoll_wait(epoll_, events.data(), kEventsAtOnce, milliseconds_to_wait());
    if (ready < 0 && errno != EINTR) return false;
    for (int i = 0; i < ready; ++i) serve_event(events[static_cast<std::size_t>(i)].data.fd);
    if (is_drain_asked_ && !is_draining_) begin_draining();
    close_overdue();
  }
  cut_off_work();
  return true;
}

void ConnectionLoop::drain() {
  is_drain_asked_ = true;
  wake();
}

void ConnectionLoop::finish(RequestInWorkPtr request, std::string unsent, bool is_kept) {
  {
    const std::lock_guard lock(mutex_);
    finished_.push_back({std::move(request), std::move(unsent), is_kept});
  }
  wake();
}

void ConnectionLoop::wake() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_, &one, sizeof one);
}

void ConnectionLoop::serve_event(int descriptor) {
  if (descriptor == listener_.descriptor()) return accept_all();
  if (descriptor == wake_) return take_finished();
  const auto found = connections_.find(descriptor);
  if (found == connections_.end()) return;
  Connection& connection = *found->second;
  switch (connection.state) {
    case Connection::State::kIdle:
    case Connection::State::kReceiving:
      return receive(connection);
    case Connection::State::kSending:
      return send_rest(connection);
    case Connection::State::kLingering:
      return drop_input(connection);
    case Connection::State::kInWork:
      return;
  }
}

// Connections come and go.

void ConnectionLoop::accept_all() {
  for (int i = 0; i < kAcceptsAtOnce; ++i) {
    const int socket =
        ::accept4(listener_.descriptor(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket >= 0) {
      add(socket);
    } else if (would_block()) {
      return;
    } else if (errno != EINTR && errno != ECONNABORTED) {
      spdlog::warn("no connection can be taken: {}", std::generic_category().message(errno));
      watch(epoll_, EPOLL_CTL_MOD, listener_.descriptor(), 0);
      is_accepting_ = false;
      accept_again_ = Clock::now() + kAcceptPause;
      return;
    }
  }
}

void ConnectionLoop::add(int socket) {
  SocketName client = remote_name(socket);
  std::size_t& of_address = per_address_[client.ip];
  if (connections_.size() >= limits_.connections || of_address >= limits_.connections_per_address) {
    if (of_address == 0) per_address_.erase(client.ip);
    return turn_away(socket);
  }
  ++of_address;
  auto connection = std::make_unique<Connection>(socket, std::move(client));
  watch(epoll_, EPOLL_CTL_ADD, socket, 0);
  wait_for(*connection, EPOLLIN, Clock::now() + limits_.idle_timeout);
  connections_.emplace(socket, std::move(connection));
  count_ = connections_.size();
}

void ConnectionLoop::turn_away(int socket) {
  const std::string answer = refuse_({503, "busy", "Too many connections are open; try again."});
  [[maybe_unused]] const ssize_t sent = send_now(socket, answer.data(), answer.size());
  ::shutdown(socket, SHUT_WR);
  ::close(socket);
}

void ConnectionLoop::close(Connection& connection) {
  set_deadline(connection, {});
  buffered_bytes_ -= connection.buffered;
  const auto of_address = per_address_.find(connection.client.ip);
  if (--of_address->second == 0) per_address_.erase(of_address);
  connections_.erase(connection.socket);
  count_ = connections_.size();
}

void ConnectionLoop::begin_draining() {
  is_draining_ = true;
  accept_all();  // Who has connected before is answered.
  listener_.close();
  const auto now = Clock::now();
  drain_deadline_ = now + limits_.drain_timeout;
  for (const auto& [socket, connection] : connections_) {
    const bool is_awaited = connection->state == Connection::State::kIdle ||
                            connection->state == Connection::State::kLingering;
    if (!is_awaited) continue;
    set_deadline(*connection, std::min(connection->deadline, now + kDrainGrace));
  }
}

bool ConnectionLoop::is_done() const {
  return is_draining_ && (connections_.empty() || Clock::now() >= drain_deadline_);
}

int ConnectionLoop::milliseconds_to_wait() const {
  auto next = Clock::time_point::max();
  if (!deadlines_.empty()) next = deadlines_.begin()->first;
  if (!is_accepting_) next = std::min(next, accept_again_);
  if (is_draining_) next = std::min(next, drain_deadline_);
  if (next == Clock::time_point::max()) return -1;
  const auto left = std::chrono::ceil<Milliseconds>(next - Clock::now()).count();
  return static_cast<int>(std::clamp<long>(left, 0, std::numeric_limits<int>::max()));
}

void ConnectionLoop::close_overdue() {
  const auto now = Clock::now();
  if (!is_accepting_ && now >= accept_again_) {
    is_accepting_ = true;
    watch(epoll_, EPOLL_CTL_MOD, listener_.descriptor(), EPOLLIN);
  }
  while (!deadlines_.empty() && deadlines_.begin()->first <= now) {
    Connection& connection = *connections_.at(deadlines_.begin()->second);
    if (connection.state == Connection::State::kReceiving) {
      refuse(connection, {408, "timeout", "The request took too long to arrive."});
    } else {
      close(connection);
    }
  }
}

void ConnectionLoop::cut_off_work() {
  // The workers notice it when they read or write; nobody else waits for these requests.
  for (const auto& [socket, connection] : connections_) ::shutdown(socket, SHUT_RDWR);
}

// Requests arrive.

void ConnectionLoop::receive(Connection& connection) {
  const ssize_t received = receive_now(connection.socket, buffer_.data(), buffer_.size());
  if (received == 0 || (received < 0 && !would_block())) return close(connection);
  const auto size = static_cast<std::size_t>(std::max<ssize_t>(0, received));
  connection.pace.add(size);
  take(connection, {buffer_.data(), size});
}

void ConnectionLoop::take(Connection& connection, std::string_view bytes) {
  using State = RequestReceiver::State;
  const State state = connection.receiver.take(bytes);
  connection.input = bytes;
  count_buffered(connection);
  if (state == State::kRefused) return refuse(connection, connection.receiver.refusal());
  if (state == State::kComplete) return dispatch(connection);
  if (buffered_bytes_ > limits_.buffered_bytes && !make_room(connection)) return;
  if (state == State::kBody) return wait_for_body(connection);
  if (connection.receiver.has_begun() && connection.state == Connection::State::kIdle) {
    connection.state = Connection::State::kReceiving;
    return wait_for(connection, EPOLLIN, Clock::now() + limits_.head_timeout);
  }
  wait_for(connection, EPOLLIN, connection.deadline);
}

/// Bodies that arrive most slowly give way, so that a few slow clients cannot take the room of all.
/// Returns whether `newest` stays.
bool ConnectionLoop::make_room(Connection& newest) {
  while (buffered_bytes_ > limits_.buffered_bytes) {
    Connection& slowest = slowest_sender(newest);
    const bool is_newest = &slowest == &newest;
    refuse(slowest,
           {503, "busy", "Too much is being received; try again."});  // It may be gone now.
    if (is_newest) return false;
  }
  return true;
}

Connection& ConnectionLoop::slowest_sender(Connection& newest) {
  constexpr double kShortest = 0.05;  // A body that has just begun is not judged yet [s].
  const auto now = Clock::now();
  const auto rate = [&](const Connection& one) {
    const std::chrono::duration<double> age = one.is_body_awaited ? now - one.pace.begin() : 0s;
    return static_cast<double>(one.buffered) / std::max(kShortest, age.count());
  };
  Connection* slowest = &newest;
  for (const auto& [socket, one] : connections_) {
    const bool is_body = one->state == Connection::State::kReceiving && one->is_body_awaited;
    if (is_body && rate(*one) < rate(*slowest)) slowest = one.get();
  }
  return *slowest;
}

void ConnectionLoop::wait_for_body(Connection& connection) {
  const RequestHead& head = connection.receiver.head();
  const bool is_large =
      head.framing.length > limits_.held_body || connection.receiver.size() > limits_.held_body;
  if (is_large) return dispatch(connection);
  if (!std::exchange(connection.is_body_awaited, true)) {
    connection.state = Connection::State::kReceiving;
    connection.pace = TransferPace(Clock::now());
    if (head.expects_continue) {
      // A few bytes on a connection that waits for them: they fit, or it is broken.
      [[maybe_unused]] const ssize_t sent =
          send_now(connection.socket, kContinue.data(), kContinue.size());
    }
  }
  wait_for(connection, EPOLLIN, connection.pace.deadline());
}

void ConnectionLoop::dispatch(Connection& connection) {
  connection.is_streamed = connection.receiver.state() != RequestReceiver::State::kComplete;
  if (connection.is_streamed && streamed_ >= limits_.streamed_requests) {
    return refuse(connection, {503, "busy", "Too many large bodies are being read; try again."});
  }
  const auto request = std::make_shared<RequestInWork>(
      RequestInWork{connection.socket, connection.client, std::move(connection.receiver),
                    std::exchange(connection.input, {})});
  if (!dispatch_(request)) {
    connection.receiver = std::move(request->receiver);
    return refuse(connection, {503, "busy", "Too many requests are in work; try again."});
  }
  connection.state = Connection::State::kInWork;
  streamed_ += connection.is_streamed ? 1U : 0U;
  set_deadline(connection, {});
}

void ConnectionLoop::take_finished() {
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t read = ::read(wake_, &count, sizeof count);
  std::vector<Finished> finished;
  {
    const std::lock_guard lock(mutex_);
    finished.swap(finished_);
  }
  for (Finished& one : finished) {
    Connection& connection = *connections_.at(one.request->socket);
    streamed_ -= connection.is_streamed ? 1U : 0U;
    connection.input = std::move(one.request->input);
    connection.receiver = RequestReceiver();
    connection.is_body_awaited = false;
    send(connection, std::move(one.unsent), one.is_kept);
  }
}

// Answers leave.

void ConnectionLoop::refuse(Connection& connection, const Refusal& refusal) {
  std::string answer = refuse_(refusal);
  connection.receiver = RequestReceiver();
  release(connection.input);
  send(connection, std::move(answer), /*is_kept=*/false);
}

void ConnectionLoop::send(Connection& connection, std::string text, bool is_kept) {
  connection.state = Connection::State::kSending;
  connection.output = std::move(text);
  connection.sent = 0;
  connection.is_kept = is_kept;
  connection.pace = TransferPace(Clock::now());
  count_buffered(connection);
  send_rest(connection);
}

void ConnectionLoop::send_rest(Connection& connection) {
  while (connection.sent < connection.output.size()) {
    const ssize_t sent = send_now(connection.socket, connection.output.data() + connection.sent,
                                  connection.output.size() - connection.sent);
    if (sent < 0 && !would_block()) return close(connection);
    if (sent < 0 && buffered_bytes_ > limits_.buffered_bytes) return close(connection);
    if (sent < 0) return wait_for(connection, EPOLLOUT, connection.pace.deadline());
    connection.sent += static_cast<std::size_t>(sent);
    connection.pace.add(static_cast<std::size_t>(sent));
  }
  release(connection.output);
  if (!connection.is_kept) return linger(connection);
  next_request(connection);
}

void ConnectionLoop::next_request(Connection& connection) {
  connection.state = Connection::State::kIdle;
  count_buffered(connection);
  const auto idle_time = is_draining_ ? Milliseconds(kDrainGrace) : limits_.idle_timeout;
  set_deadline(connection, Clock::now() + idle_time);
  const std::string input = std::exchange(connection.input, {});
  take(connection, input);
}

void ConnectionLoop::linger(Connection& connection) {
  // Closing a socket with unread bytes resets the connection, and the answer could be lost.
  ::shutdown(connection.socket, SHUT_WR);
  connection.state = Connection::State::kLingering;
  connection.receiver = RequestReceiver();
  release(connection.input);
  connection.pace = TransferPace(Clock::now());
  count_buffered(connection);
  drop_input(connection);
}

void ConnectionLoop::drop_input(Connection& connection) {
  const ssize_t received = receive_now(connection.socket, buffer_.data(), buffer_.size());
  if (received == 0 || (received < 0 && !would_block())) return close(connection);
  if (received > 0) connection.pace.add(static_cast<std::size_t>(received));
  if (connection.pace.bytes() > kMaxDroppedBytes) return close(connection);
  const auto deadline = connection.pace.deadline();
  wait_for(connection, EPOLLIN,
           is_draining_ ? std::min(deadline, Clock::now() + kDrainGrace) : deadline);
}

// What the loop waits for.

void ConnectionLoop::wait_for(Connection& connection, unsigned events, Clock::time_point deadline) {
  set_deadline(connection, deadline);
  watch(epoll_, EPOLL_CTL_MOD, connection.socket, events | EPOLLONESHOT);
}

void ConnectionLoop::set_deadline(Connection& connection, Clock::time_point deadline) {
  if (connection.deadline == deadline) return;
  deadlines_.erase({connection.deadline, connection.socket});
  connection.deadline = deadline;
  if (deadline != Clock::time_point{}) deadlines_.emplace(deadline, connection.socket);
}

void ConnectionLoop::count_buffered(Connection& connection) {
  const std::size_t buffered =
      connection.receiver.size() + connection.input.size() + connection.output.size();
  buffered_bytes_ += buffered - connection.buffered;
  connection.buffered = buffered;
}

}  // namespace cornerfix::server
