/// \file  Calls of the HTTP API as curl lines that a shell runs as they stand.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <cornerfix/result.hpp>

#include "clients/cpp/http_request.hpp"

namespace cornerfix::client {

/// In a path, stands for the id that a printed line has put into the shell's variable SESSION.
constexpr std::string_view kSessionVariable = "$SESSION";

/// A word that a POSIX shell takes literally, with any content.
[[nodiscard]] std::string shell_quote(std::string_view text);

/// Turns calls into curl lines. A body above kMaxInlineBytes goes to a file that its line names.
class CurlWriter {
 public:
  static constexpr std::size_t kMaxInlineBytes = 2000;

  /// \param body_directory  Made with the first body that goes to a file.
  CurlWriter(ServerAddress server, std::filesystem::path body_directory);

  /// Without a newline at its end. A line that creates a session keeps its id in SESSION.
  [[nodiscard]] Result<std::string> line(const HttpRequest& request);

 private:
  [[nodiscard]] Result<std::filesystem::path> write_body(const std::string& body);

  ServerAddress server_;
  std::filesystem::path body_directory_;
  int bodies_written_ = 0;
};

}  // namespace cornerfix::client
