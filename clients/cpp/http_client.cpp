#include "clients/cpp/http_client.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

// After all else: its <resolv.h> defines macros.
#include <httplib.h>

namespace cornerfix::client {

namespace {

constexpr int kMaxAttempts = 10;
constexpr int kMaxRetryWaitSeconds = 30;
constexpr auto kAnswerTimeout = std::chrono::seconds(120);  // A large map is made anew meanwhile.

struct Origin {
  std::string scheme_host_port;
  std::string base_path;  ///< Without a slash at its end.
};

Result<Origin> split_url(const std::string& url) {
  const std::size_t host = url.find("://");
  const bool is_http = url.starts_with("http://") || url.starts_with("https://");
  if (!is_http || host + 3 >= url.size() || url[host + 3] == '/') {
    return Error{ErrorCode::kInvalidArgument, "expected http://HOST:PORT", url};
  }
  const std::size_t path = std::min(url.find('/', host + 3), url.size());
  Origin origin{url.substr(0, path), url.substr(path)};
  while (!origin.base_path.empty() && origin.base_path.back() == '/') origin.base_path.pop_back();
  return origin;
}

ErrorCode code_for(int status) {
  switch (status) {
    case 400:
      return ErrorCode::kMalformed;
    case 404:
      return ErrorCode::kNotFound;
    case 409:
      return ErrorCode::kConflict;
    case 413:
      return ErrorCode::kTooLarge;
    case 422:
      return ErrorCode::kInvalidArgument;
    case 429:
    case 503:
      return ErrorCode::kUnavailable;
    case 507:
      return ErrorCode::kStorageFull;
    default:
      return ErrorCode::kInternal;
  }
}

std::string text_member(const nlohmann::json& object, const char* key) {
  const auto member = object.find(key);
  return member != object.end() && member->is_string() ? member->get<std::string>() : "";
}

/// What a problem document says, in a line.
std::string describe_problem(const std::string& body) {
  const auto problem = nlohmann::json::parse(body, nullptr, false);
  if (!problem.is_object()) return body.substr(0, 200);
  std::string text = text_member(problem, "detail");
  if (text.empty()) text = text_member(problem, "title");
  const auto errors = problem.find("errors");
  if (errors == problem.end() || !errors->is_array()) return text;
  const std::string first = text;
  for (const auto& error : *errors) {
    if (!error.is_object()) continue;
    const std::string pointer = text_member(error, "pointer");
    const std::string detail = text_member(error, "detail");
    text += detail == first ? " (" + pointer : "; " + pointer;
    text += detail == first ? ")" : ": " + detail;
  }
  return text;
}

int retry_after_seconds(const httplib::Response& response) {
  const std::string header = response.get_header_value("Retry-After");
  int seconds = 1;
  std::from_chars(header.data(), header.data() + header.size(), seconds);
  return std::clamp(seconds, 0, kMaxRetryWaitSeconds);
}

bool asks_to_wait(const httplib::Response& response) {
  return response.status == 429 || response.status == 503;
}

}  // namespace

class HttpClient::Connection {
 public:
  Connection(const ServerAddress& server, Origin origin)
      : token_(server.token),
        base_path_(std::move(origin.base_path)),
        url_(server.url),
        client_(origin.scheme_host_port) {
    client_.set_tcp_nodelay(true);  // Nagle would cost 40 ms a request.
    client_.set_keep_alive(true);
    client_.set_read_timeout(kAnswerTimeout);
    client_.set_write_timeout(kAnswerTimeout);
  }

  Result<std::string> send(const HttpRequest& request) {
    bool may_repeat = !request.creates_session;
    for (int attempt = 1;; ++attempt) {
      const httplib::Result result = send_once(request);
      if (!result) {
        if (!std::exchange(may_repeat, false)) return unreachable(result.error());
        continue;
      }
      if (asks_to_wait(*result) && attempt < kMaxAttempts) {
        std::this_thread::sleep_for(std::chrono::seconds(retry_after_seconds(*result)));
        continue;
      }
      if (result->status >= 200 && result->status < 300) return result->body;
      return Error{code_for(result->status),
                   std::to_string(result->status) + " " + describe_problem(result->body),
                   request.method + " " + request.path};
    }
  }

  Result<HttpReply> ask(const HttpRequest& request) {
    httplib::Result result = send_once(request);
    if (!result) return unreachable(result.error());
    return HttpReply{result->status, std::move(result->body)};
  }

 private:
  httplib::Result send_once(const HttpRequest& request) {
    httplib::Request plain = to_httplib(request);
    if (request.form.empty()) return client_.send(plain);
    httplib::MultipartFormDataItems items;
    for (const FormFile& file : request.form) {
      items.push_back({file.part, file.content,
                       std::filesystem::path(file.path).filename().string(),
                       "application/octet-stream"});
    }
    return client_.Put(plain.path, plain.headers, items);
  }

  [[nodiscard]] httplib::Request to_httplib(const HttpRequest& request) const {
    httplib::Request out;
    out.method = request.method;
    out.path = base_path_ + request.path;
    out.set_header("Accept", "application/json");
    if (!token_.empty()) out.set_header("Authorization", "Bearer " + token_);
    if (!request.body.empty()) out.set_header("Content-Type", request.content_type);
    out.body = request.body;
    return out;
  }

  [[nodiscard]] Error unreachable(httplib::Error error) const {
    return {ErrorCode::kUnavailable,
            "no answer: " + httplib::to_string(error) + "; is the server running there?", url_};
  }

  std::string token_;
  std::string base_path_;
  std::string url_;
  httplib::Client client_;
};

HttpClient::HttpClient(std::unique_ptr<Connection> connection)
    : connection_(std::move(connection)) {}
HttpClient::~HttpClient() = default;
HttpClient::HttpClient(HttpClient&&) noexcept = default;

Result<HttpClient> HttpClient::create(const ServerAddress& server) {
  Result<Origin> origin = split_url(server.url);
  if (!origin) return origin.error();
  auto connection = std::make_unique<Connection>(server, std::move(*origin));
  return HttpClient(std::move(connection));
}

Result<std::string> HttpClient::send(const HttpRequest& request) {
  return connection_->send(request);
}

Result<HttpReply> HttpClient::ask(const HttpRequest& request) { return connection_->ask(request); }

}  // namespace cornerfix::client
