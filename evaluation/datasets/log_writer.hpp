/// \file  Writes runs in the JSON lines format that log_reader.hpp reads.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include <cornerfix/result.hpp>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// Writes scan by scan: ranges to the millimetre, poses to the micrometre and microradian. Gzip'd
/// where the path ends with .gz. One thread at a time.
class LogWriter {
 public:
  /// Creates or truncates the file and writes the header, marked as simulated.
  [[nodiscard]] static Result<LogWriter> create(const std::filesystem::path& path,
                                                const LogHeader& header);
  ~LogWriter();
  LogWriter(LogWriter&&) noexcept;

  [[nodiscard]] Result<void> write(const LogScan& scan);
  /// Nothing is surely on disk before. The writer is of no use afterwards.
  [[nodiscard]] Result<void> close();

 private:
  class File;
  explicit LogWriter(std::unique_ptr<File> file);

  std::unique_ptr<File> file_;
};

/// A whole log. `progress` is called with the share of the scans written, in [0, 1], and may be
/// empty.
[[nodiscard]] Result<void> write_log(const std::filesystem::path& path, const RecordedLog& log,
                                     const std::function<void(double)>& progress = {});

}  // namespace cornerfix::evaluation
