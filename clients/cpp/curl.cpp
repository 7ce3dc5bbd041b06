#include "clients/cpp/curl.hpp"

#include <cstdio>
#include <fstream>
#include <utility>

namespace cornerfix::client {

namespace {

/// The URL quoted, but for the shell's variable in it.
std::string quote_url(const std::string& url) {
  const std::size_t variable = url.find(kSessionVariable);
  if (variable == std::string::npos) return shell_quote(url);
  return shell_quote(url.substr(0, variable)) + '"' + std::string(kSessionVariable) + '"' +
         shell_quote(url.substr(variable + kSessionVariable.size()));
}

}  // namespace

std::string shell_quote(std::string_view text) {
  std::string out = "'";
  for (const char character : text) {
    if (character == '\'') {
      out += "'\\''";  // Ends the word, adds a quote, begins it anew.
    } else {
      out += character;
    }
  }
  return out + "'";
}

CurlWriter::CurlWriter(ServerAddress server, std::filesystem::path body_directory)
    : server_(std::move(server)), body_directory_(std::move(body_directory)) {
  while (server_.url.ends_with('/')) server_.url.pop_back();
}

Result<std::string> CurlWriter::line(const HttpRequest& request) {
  std::string line = "curl -sS --fail-with-body";
  if (request.method != "GET") line += " -X " + request.method;
  line += ' ' + quote_url(server_.url + request.path);
  if (!server_.token.empty())
    line += " -H " + shell_quote("Authorization: Bearer " + server_.token);
  if (!request.form.empty()) {
    for (const FormFile& file : request.form)
      line += " -F " + shell_quote(file.part + "=@" + file.path);
  } else if (!request.body.empty()) {
    line += " -H " + shell_quote("Content-Type: " + request.content_type) + " --data-binary ";
    if (!request.body_path.empty()) {
      line += shell_quote('@' + request.body_path);
    } else if (request.body.size() <= kMaxInlineBytes) {
      line += shell_quote(request.body);
    } else {
      const Result<std::filesystem::path> file = write_body(request.body);
      if (!file) return file.error();
      line += shell_quote('@' + file->string());
    }
  } else if (request.method == "POST") {
    line += " -d ''";  // A server would wait for a body of unknown length.
  }
  if (!request.answer_path.empty()) line += " -o " + shell_quote(request.answer_path);
  if (!request.creates_session) return line;
  return "SESSION=$(" + line + R"( | grep -o '"id": *"[^"]*"' | head -n 1 | cut -d '"' -f 4))";
}

Result<std::filesystem::path> CurlWriter::write_body(const std::string& body) {
  std::error_code error;
  std::filesystem::create_directories(body_directory_, error);
  char name[32];
  std::snprintf(name, sizeof name, "body-%05d.json", ++bodies_written_);
  const std::filesystem::path path = body_directory_ / name;
  std::ofstream file(path, std::ios::binary);
  if (!file.write(body.data(), static_cast<std::streamsize>(body.size())).flush()) {
    return Error{ErrorCode::kUnavailable, "cannot be written", path.string()};
  }
  return path;
}

}  // namespace cornerfix::client
