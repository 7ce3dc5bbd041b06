#include "integration/http_client.hpp"

#include <algorithm>
#include <cctype>

#include <httplib.h>

namespace cornerfix::testing {
namespace {

constexpr int kTimeoutS = 60;

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

Reply to_reply(const httplib::Result& result) {
  if (!result) return {0, {}, httplib::to_string(result.error())};
  Reply reply{result->status, {}, result->body};
  for (const auto& [name, value] : result->headers) reply.headers.emplace(lower_case(name), value);
  return reply;
}

}  // namespace

std::string Reply::header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

struct HttpClient::Impl {
  explicit Impl(int port) : client("127.0.0.1", port) {
    client.set_keep_alive(true);
    client.set_tcp_nodelay(true);
    client.set_read_timeout(kTimeoutS);
    client.set_write_timeout(kTimeoutS);
  }
  httplib::Client client;
  httplib::Headers headers;
};

HttpClient::HttpClient(int port) : impl_(std::make_unique<Impl>(port)) {}
HttpClient::~HttpClient() = default;
HttpClient::HttpClient(HttpClient&&) noexcept = default;

void HttpClient::set_header(const std::string& name, const std::string& value) {
  impl_->headers.emplace(name, value);
}

Reply HttpClient::get(const std::string& path, const HeaderMap& headers) {
  return send("GET", path, "", "", headers);
}
Reply HttpClient::remove(const std::string& path) { return send("DELETE", path, "", ""); }
Reply HttpClient::put(const std::string& path, const Json& document) {
  return send("PUT", path, document.dump(), "application/json");
}
Reply HttpClient::post(const std::string& path, const Json& document) {
  return send("POST", path, document.dump(), "application/json");
}

Reply HttpClient::send(const std::string& method, const std::string& path, const std::string& body,
                       const std::string& content_type, const HeaderMap& headers) {
  httplib::Request request;
  request.method = method;
  request.path = path;
  request.body = body;
  request.headers = impl_->headers;
  for (const auto& [name, value] : headers) request.headers.emplace(name, value);
  if (!content_type.empty()) request.headers.emplace("Content-Type", content_type);
  return to_reply(impl_->client.send(request));
}

Reply HttpClient::post_chunked(const std::string& path, const std::string& body,
                               const std::string& content_type) {
  constexpr std::size_t kChunk = 10'000;
  const auto result = impl_->client.Post(
      path, impl_->headers,
      [&](std::size_t offset, httplib::DataSink& sink) {
        const std::size_t size = std::min(kChunk, body.size() - offset);
        if (size > 0) sink.write(body.data() + offset, size);
        if (offset + size == body.size()) sink.done();
        return true;
      },
      content_type);
  return to_reply(result);
}

Reply HttpClient::stream(const std::string& path,
                         const std::function<bool(std::string_view)>& take) {
  return to_reply(impl_->client.Get(path, impl_->headers, [&](const char* data, std::size_t size) {
    return take({data, size});
  }));
}

std::string exchange_bytes(int port, std::string_view request) {
  RawConnection connection(port);
  connection.send(request);
  return connection.read_to_end();
}

}  // namespace cornerfix::testing
