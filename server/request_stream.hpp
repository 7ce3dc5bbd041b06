/// \file  One request and its answer as the HTTP library reads and writes them.
#pragma once

#include <memory>
#include <string>

#include "server/connection.hpp"

namespace httplib {  // NOLINT(readability-identifier-naming): the library's own name.
class Stream;
struct Request;
}  // namespace httplib

namespace cornerfix::server {

/// Reads what was received of the request, then the rest from its socket. Ends where the request
/// ends. Never waits for the client to take the answer, unless the library asks whether the stream
/// is writable. The request outlives the stream.
class RequestStream {
 public:
  explicit RequestStream(RequestInWork& request);
  ~RequestStream();
  RequestStream(const RequestStream&) = delete;
  RequestStream& operator=(const RequestStream&) = delete;

  [[nodiscard]] httplib::Stream& bytes();

  /// The request as the library has it, known once its head is parsed. The code that answers it
  /// sets its Connection header to "close" when the connection cannot be kept.
  void watch(const httplib::Request& parsed);
  [[nodiscard]] bool is_closing() const;

  /// What the client has not taken of the answer.
  [[nodiscard]] std::string take_unsent();

 private:
  class Bytes;
  std::unique_ptr<Bytes> bytes_;
};

}  // namespace cornerfix::server
