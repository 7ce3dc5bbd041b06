/// \file  An HTTP server on a free port that answers as a test wants and remembers what was asked.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cornerfix::testing {

struct FakeRequest {
  std::string method;
  std::string path;  ///< With its query.
  std::string body;
  std::string content_type;
  std::string authorization;
  std::uint64_t length;  ///< Of the body, also of a form, which is not in `body`.
};

struct FakeAnswer {
  int status = 200;
  std::string body = {};
  std::string retry_after = {};
};

/// Serves until it is destroyed. `answer` is called for one request at a time.
class FakeServer {
 public:
  explicit FakeServer(std::function<FakeAnswer(const FakeRequest&)> answer);
  ~FakeServer();
  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;

  [[nodiscard]] std::string url() const;
  [[nodiscard]] std::vector<FakeRequest> requests() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornerfix::testing
