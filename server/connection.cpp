#include "server/connection.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "server/socket_io.hpp"

namespace cornerfix::server {
namespace {

using Milliseconds = std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

constexpr Milliseconds kLingerTime{2000};
constexpr std::size_t kMaxLingerBytes = std::size_t{64} << 20U;

Milliseconds time_until(SteadyClock::time_point deadline) {
  const auto left = std::chrono::ceil<Milliseconds>(deadline - SteadyClock::now());
  return std::max(left, Milliseconds{0});
}

}  // namespace

Connection::~Connection() {
  ::shutdown(socket_, SHUT_RDWR);
  ::close(socket_);
}

bool Connection::receive_head() {
  receiver_ = RequestReceiver();
  std::array<char, 4096> buffer;
  SteadyClock::time_point deadline = SteadyClock::now() + timeouts_.request;
  for (;;) {
    if (!input_.empty() && !receiver_.has_begun()) deadline = SteadyClock::now() + timeouts_.head;
    std::string_view rest = input_;
    const auto state = receiver_.take(rest);
    input_.erase(0, input_.size() - rest.size());
    if (state == RequestReceiver::State::kRefused) refusal_ = receiver_.refusal();
    if (state != RequestReceiver::State::kHead) return !refusal_;
    const bool is_late = !wait_for(socket_, POLLIN, time_until(deadline));
    if (is_late && receiver_.has_begun()) {
      refusal_ = Refusal{408, "timeout", "The head of the request took too long to arrive."};
    }
    if (is_late) return false;
    const ssize_t received = receive_now(socket_, buffer.data(), buffer.size());
    if (received <= 0) return false;
    input_.assign(buffer.data(), static_cast<std::size_t>(received));
  }
}

void Connection::send_last(std::string_view answer) {
  if (send_now(socket_, answer.data(), answer.size()) > 0) linger();
}

void Connection::linger() {
  // Closing a socket with unread bytes resets the connection, and the answer could be lost.
  ::shutdown(socket_, SHUT_WR);
  std::array<char, 16384> buffer;
  const auto deadline = SteadyClock::now() + kLingerTime;
  for (std::size_t dropped = 0; dropped < kMaxLingerBytes;) {
    if (!wait_for(socket_, POLLIN, time_until(deadline))) return;
    const ssize_t received = receive_now(socket_, buffer.data(), buffer.size());
    if (received <= 0) return;
    dropped += static_cast<std::size_t>(received);
  }
}

}  // namespace cornerfix::server
