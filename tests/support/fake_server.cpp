#include "support/fake_server.hpp"

#include <mutex>
#include <thread>

#include <httplib.h>

namespace cornerfix::testing {

class FakeServer::Impl {
 public:
  explicit Impl(std::function<FakeAnswer(const FakeRequest&)> answer) : answer_(std::move(answer)) {
    server_.set_tcp_nodelay(true);
    const auto handler = [this](const httplib::Request& request, httplib::Response& response) {
      handle(request, response);
    };
    server_.Get(".*", handler).Put(".*", handler).Post(".*", handler).Delete(".*", handler);
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    // It cannot be stopped before it runs.
    while (!server_.is_running()) std::this_thread::yield();
  }

  ~Impl() {
    server_.stop();
    thread_.join();
  }

  [[nodiscard]] int port() const { return port_; }

  [[nodiscard]] std::vector<FakeRequest> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

 private:
  void handle(const httplib::Request& request, httplib::Response& response) {
    const std::lock_guard lock(mutex_);
    requests_.push_back({request.method, request.target, request.body,
                         request.get_header_value("Content-Type"),
                         request.get_header_value("Authorization"),
                         request.get_header_value<std::uint64_t>("Content-Length")});
    const FakeAnswer answer = answer_(requests_.back());
    response.status = answer.status;
    if (!answer.retry_after.empty()) response.set_header("Retry-After", answer.retry_after);
    if (!answer.body.empty()) response.set_content(answer.body, "application/json");
  }

  std::function<FakeAnswer(const FakeRequest&)> answer_;
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
  mutable std::mutex mutex_;
  std::vector<FakeRequest> requests_;
};

FakeServer::FakeServer(std::function<FakeAnswer(const FakeRequest&)> answer)
    : impl_(std::make_unique<Impl>(std::move(answer))) {}
FakeServer::~FakeServer() = default;

std::string FakeServer::url() const { return "http://127.0.0.1:" + std::to_string(impl_->port()); }
std::vector<FakeRequest> FakeServer::requests() const { return impl_->requests(); }

}  // namespace cornerfix::testing
