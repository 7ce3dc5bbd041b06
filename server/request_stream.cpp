#include "server/request_stream.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "server/socket_io.hpp"

// After all else: its <resolv.h> defines macros.
#include <httplib.h>

namespace cornerfix::server {
namespace {

using Milliseconds = std::chrono::milliseconds;

constexpr Milliseconds kWriteTimeout{5000};
constexpr std::size_t kLargeWrite = std::size_t{64} << 10U;

Milliseconds time_left(const TransferPace& pace) {
  const auto left = pace.deadline() - TransferPace::Clock::now();
  return std::max(std::chrono::ceil<Milliseconds>(left), Milliseconds{0});
}

}  // namespace

class RequestStream::Bytes final : public httplib::Stream {
 public:
  explicit Bytes(RequestInWork& request)
      : request_(request), pace_(TransferPace::Clock::now()), text_(request.receiver.take_text()) {}

  /// Whether bytes of the request are there, or come in time.
  [[nodiscard]] bool is_readable() const override;
  /// Sends what was written so far, for answers that go on for long. False when the client does not
  /// take it in time.
  [[nodiscard]] bool is_writable() const override;
  ssize_t read(char* to, std::size_t size) override;
  ssize_t write(const char* from, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] socket_t socket() const override { return request_.socket; }

  void watch(const httplib::Request& parsed) { parsed_ = &parsed; }
  [[nodiscard]] bool is_closing() const { return is_closing_; }
  [[nodiscard]] std::string take_unsent();

 private:
  bool receive();
  bool send_continue();
  bool send_some() const;

  RequestInWork& request_;
  TransferPace pace_;  ///< Of the body.
  std::string text_;   ///< Received and not yet read from `text_begin_` on.
  std::size_t text_begin_ = 0;
  mutable std::string output_;  ///< Written and not yet sent.
  const httplib::Request* parsed_ = nullptr;
  bool is_closing_ = false;
  bool has_continued_ = false;
};

bool RequestStream::Bytes::is_readable() const {
  return text_begin_ < text_.size() || wait_for(request_.socket, POLLIN, time_left(pace_));
}

ssize_t RequestStream::Bytes::read(char* to, std::size_t size) {
  while (text_begin_ == text_.size()) {
    if (request_.receiver.state() == RequestReceiver::State::kComplete) return 0;
    if (!receive()) return -1;
  }
  const std::size_t taken = std::min(size, text_.size() - text_begin_);
  std::memcpy(to, text_.data() + text_begin_, taken);
  text_begin_ += taken;
  return static_cast<ssize_t>(taken);
}

bool RequestStream::Bytes::receive() {
  if (request_.input.empty()) {
    std::array<char, 16384> buffer;
    if (!send_continue()) return false;
    if (!wait_for(request_.socket, POLLIN, time_left(pace_))) return false;
    const ssize_t received = receive_now(request_.socket, buffer.data(), buffer.size());
    if (received <= 0) return false;
    request_.input.assign(buffer.data(), static_cast<std::size_t>(received));
    pace_.add(static_cast<std::size_t>(received));
  }
  std::string_view rest = request_.input;
  const bool is_good = request_.receiver.take(rest) != RequestReceiver::State::kRefused;
  request_.input.erase(0, request_.input.size() - rest.size());
  text_ = request_.receiver.take_text();
  text_begin_ = 0;
  return is_good;
}

bool RequestStream::Bytes::send_continue() {
  constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
  if (!request_.receiver.head().expects_continue || std::exchange(has_continued_, true)) {
    return true;
  }
  output_ += kContinue;
  return send_some();
}

ssize_t RequestStream::Bytes::write(const char* from, std::size_t size) {
  // What the library answers before it has parsed the request is an error of the request's form.
  is_closing_ |= parsed_ == nullptr || parsed_->get_header_value("Connection") == "close";
  std::string_view rest(from, size);
  if (size >= kLargeWrite && send_some() && output_.empty()) {
    const ssize_t sent = send_now(request_.socket, from, size);
    if (sent > 0) rest.remove_prefix(static_cast<std::size_t>(sent));
  }
  output_ += rest;
  return static_cast<ssize_t>(size);
}

bool RequestStream::Bytes::send_some() const {
  const ssize_t sent = send_now(request_.socket, output_.data(), output_.size());
  if (sent > 0) output_.erase(0, static_cast<std::size_t>(sent));
  return sent >= 0 || errno == EAGAIN || errno == EWOULDBLOCK;
}

bool RequestStream::Bytes::is_writable() const {
  while (!output_.empty()) {
    if (!wait_for(request_.socket, POLLOUT, kWriteTimeout) || !send_some()) return false;
  }
  return true;
}

std::string RequestStream::Bytes::take_unsent() {
  if (!output_.empty()) send_some();
  return std::exchange(output_, {});
}

void RequestStream::Bytes::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip = request_.client.ip;
  port = request_.client.port;
}

void RequestStream::Bytes::get_local_ip_and_port(std::string& ip, int& port) const {
  SocketName name = local_name(request_.socket);
  ip = std::move(name.ip);
  port = name.port;
}

RequestStream::RequestStream(RequestInWork& request) : bytes_(std::make_unique<Bytes>(request)) {}
RequestStream::~RequestStream() = default;

httplib::Stream& RequestStream::bytes() { return *bytes_; }
void RequestStream::watch(const httplib::Request& parsed) { bytes_->watch(parsed); }
bool RequestStream::is_closing() const { return bytes_->is_closing(); }
std::string RequestStream::take_unsent() { return bytes_->take_unsent(); }

}  // namespace cornerfix::server
