/// \file  Tables of results as files: comma-separated, a header line, SI units in the names.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace cornerfix::bench {

/// Rows go out as they come, so that a run that is ended early leaves what it had.
class CsvFile {
 public:
  /// Creates or truncates `path`. Ends the program when it cannot be written.
  CsvFile(const std::filesystem::path& path, std::string_view header) : path_(path), file_(path) {
    file_ << header << '\n';
    check();
  }
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  template <typename... Values>
  void row(const Values&... values) {
    const char* separator = "";
    ((file_ << separator << values, separator = ","), ...);
    file_ << '\n';
    file_.flush();
    check();
  }

 private:
  void check() const {
    if (file_) return;
    std::fprintf(stderr, "cornerfix-bench: %s: cannot be written\n", path_.c_str());
    std::exit(1);
  }

  std::filesystem::path path_;
  std::ofstream file_;
};

}  // namespace cornerfix::bench
