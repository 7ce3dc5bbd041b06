/// \file  The scans of a log that can make a map, one after the other.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/datasets/log_reader.hpp"
#include "evaluation/datasets/log_survey.hpp"

namespace cornerfix::evaluation {

struct MappingScanOptions {
  LogSelection selection;
  double split = 1.0;          ///< Take them from this first share of the log.
  std::size_t stride = 1;      ///< Every n-th scan.
  bool without_poses = false;  ///< All scans, whose poses are to be found.
};

/// Those with a reference pose; in a log that marks key scans those only, since the poses between
/// them are interpolated. All of them where poses do not matter. Reads the log twice and holds one
/// scan of it.
class MappingScans {
 public:
  /// An error as well when there would be none. `progress` as in survey_log().
  [[nodiscard]] static Result<MappingScans> open(const std::filesystem::path& path,
                                                 const MappingScanOptions& options,
                                                 const std::function<void(double)>& progress = {});

  [[nodiscard]] std::optional<LogScan> next();
  /// The next `size` scans, fewer at the end.
  [[nodiscard]] std::vector<LogScan> next_batch(std::size_t size);
  [[nodiscard]] const LogReader& log() const { return reader_; }
  /// Of the whole log, as in LogSurvey.
  [[nodiscard]] const std::string& remarks() const { return remarks_; }
  [[nodiscard]] std::size_t count() const { return count_; }  ///< Given out so far.
  /// Share of them that was given out, in [0, 1].
  [[nodiscard]] double progress() const {
    return static_cast<double>(taken_) / static_cast<double>(wanted_);
  }

 private:
  MappingScans(LogReader reader, const LogSurvey& survey, const MappingScanOptions& options);

  LogReader reader_;
  std::string remarks_;
  std::size_t stride_;
  bool posed_only_;
  bool key_scans_only_;
  std::size_t wanted_;  ///< Of those that posed_only_ allows, key scans or not.
  std::size_t index_ = 0;
  std::size_t taken_ = 0;
  std::size_t count_ = 0;
};

}  // namespace cornerfix::evaluation
