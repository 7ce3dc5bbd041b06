/// \file  One request and its answer as the HTTP library reads and writes them.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include "server/request_receiver.hpp"

// After all else: its <resolv.h> defines macros.
#include <httplib.h>

namespace cornerfix::server {

struct StreamTimeouts {
  std::chrono::milliseconds read;   ///< For the next bytes of a request.
  std::chrono::milliseconds write;  ///< For the client to take the next bytes of an answer.
};

/// Reads what `receiver` has of the request, then the rest from the socket through `receiver`. Ends
/// where the request ends. Bytes of the next request stay in `input`. All outlive the stream.
class RequestStream final : public httplib::Stream {
 public:
  RequestStream(int socket, RequestReceiver& receiver, std::string& input, StreamTimeouts timeouts);

  [[nodiscard]] bool is_readable() const override;
  [[nodiscard]] bool is_writable() const override;
  ssize_t read(char* to, std::size_t size) override;
  ssize_t write(const char* from, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] socket_t socket() const override { return socket_; }

  /// The request as the library has it, known once its head is parsed. Whoever answers it sets its
  /// Connection header to "close" when the connection cannot be kept.
  void watch(const httplib::Request& request) { request_ = &request; }
  [[nodiscard]] bool is_closing() const { return is_closing_; }

 private:
  bool receive();
  bool send_continue();

  int socket_;
  RequestReceiver& receiver_;
  std::string& input_;
  StreamTimeouts timeouts_;
  std::string text_;  ///< Received and not yet read from `text_begin_` on.
  std::size_t text_begin_ = 0;
  const httplib::Request* request_ = nullptr;
  bool is_closing_ = false;
  bool has_continued_ = false;
};

}  // namespace cornerfix::server
