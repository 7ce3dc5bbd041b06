#include "server/request_stream.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "server/socket_io.hpp"

namespace cornerfix::server {

RequestStream::RequestStream(int socket, RequestReceiver& receiver, std::string& input,
                             StreamTimeouts timeouts)
    : socket_(socket),
      receiver_(receiver),
      input_(input),
      timeouts_(timeouts),
      text_(receiver.take_text()) {}

bool RequestStream::is_readable() const {
  return text_begin_ < text_.size() || wait_for(socket_, POLLIN, timeouts_.read);
}

bool RequestStream::is_writable() const { return wait_for(socket_, POLLOUT, timeouts_.write); }

ssize_t RequestStream::read(char* to, std::size_t size) {
  while (text_begin_ == text_.size()) {
    if (receiver_.state() == RequestReceiver::State::kComplete) return 0;
    if (!receive()) return -1;
  }
  const std::size_t taken = std::min(size, text_.size() - text_begin_);
  std::memcpy(to, text_.data() + text_begin_, taken);
  text_begin_ += taken;
  return static_cast<ssize_t>(taken);
}

bool RequestStream::receive() {
  if (input_.empty()) {
    if (!send_continue()) return false;
    std::array<char, 16384> buffer;
    if (!wait_for(socket_, POLLIN, timeouts_.read)) return false;
    const ssize_t received = receive_now(socket_, buffer.data(), buffer.size());
    if (received <= 0) return false;
    input_.assign(buffer.data(), static_cast<std::size_t>(received));
  }
  std::string_view rest = input_;
  const bool is_good = receiver_.take(rest) != RequestReceiver::State::kRefused;
  input_.erase(0, input_.size() - rest.size());
  text_ = receiver_.take_text();
  text_begin_ = 0;
  return is_good;
}

bool RequestStream::send_continue() {
  constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
  if (!receiver_.head().expects_continue || std::exchange(has_continued_, true)) return true;
  return send_now(socket_, kContinue.data(), kContinue.size()) ==
         static_cast<ssize_t>(kContinue.size());
}

ssize_t RequestStream::write(const char* from, std::size_t size) {
  // What the library answers before it has parsed the request is an error of the request's form.
  is_closing_ |= request_ == nullptr || request_->get_header_value("Connection") == "close";
  return is_writable() ? send_now(socket_, from, size) : -1;
}

void RequestStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  SocketName name = remote_name(socket_);
  ip = std::move(name.ip);
  port = name.port;
}

void RequestStream::get_local_ip_and_port(std::string& ip, int& port) const {
  SocketName name = local_name(socket_);
  ip = std::move(name.ip);
  port = name.port;
}

}  // namespace cornerfix::server
