/// \file  A program as a process of its own.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>
#include <string>
#include <vector>

namespace cornerfix::testing {

/// Killed when it goes out of scope. Its errors go to /dev/null.
class Program {
 public:
  /// \param environment  NAME=VALUE, on top of this process' own.
  Program(const std::string& path, const std::vector<std::string>& arguments,
          const std::vector<std::string>& environment = {}) {
    std::vector<std::string> words = {path};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<std::string> settings = environment;  // Of two with one name the first one counts.
    for (char** own = environ; *own != nullptr; ++own) settings.emplace_back(*own);
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    const int error = posix_spawn(&pid_, path.c_str(), &actions, nullptr, pointers(words).data(),
                                  pointers(settings).data());
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    stdout_ = ends[0];
    if (error != 0) throw std::runtime_error("cannot start " + path);
  }
  ~Program() {
    if (pid_ > 0) {
      signal(SIGKILL);
      wait();
    }
    ::close(stdout_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// The next line of its output; "" at the end.
  std::string read_line() {
    std::string line;
    for (char c = 0; ::read(stdout_, &c, 1) == 1 && c != '\n';) line += c;
    return line;
  }

  void signal(int number) const { ::kill(pid_, number); }

  /// The exit code, or minus the signal that ended it. All that it wrote after the lines read is in
  /// `rest_of_output`.
  int wait() {
    char buffer[4096];
    for (ssize_t size = 0; (size = ::read(stdout_, buffer, sizeof buffer)) > 0;) {
      rest_.append(buffer, static_cast<std::size_t>(size));
    }
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  [[nodiscard]] const std::string& rest_of_output() const { return rest_; }

 private:
  static std::vector<char*> pointers(std::vector<std::string>& texts) {
    std::vector<char*> out;
    for (std::string& text : texts) out.push_back(text.data());
    out.push_back(nullptr);
    return out;
  }

  pid_t pid_ = -1;
  int stdout_ = -1;
  std::string rest_;
};

}  // namespace cornerfix::testing
