/// \file  How far long work has come: a bar on a terminal, plain lines elsewhere.
#pragma once

#include <cstdio>
#include <string>

namespace cornerfix::cli {

/// Writes to a stream that outlives it, stderr in the commands, so that results on stdout stay
/// clean. One thread at a time.
class Progress {
 public:
  Progress(std::string label, std::FILE* stream, bool is_terminal);
  /// On stderr.
  explicit Progress(std::string label);
  /// Leaves the line that it wrote last as it is.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `share` in [0, 1]. Cheap to call often: writes at each percent on a terminal, at each tenth
  /// elsewhere.
  void update(double share);

 private:
  std::string label_;
  std::FILE* stream_;
  bool is_terminal_;
  int last_percent_ = -1;
};

}  // namespace cornerfix::cli
