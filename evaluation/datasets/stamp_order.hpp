/// \file  Makes the stamps of a log strictly increase, as all who use its scans need it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/datasets/log_fault.hpp"
#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// Takes the scans of a log in its order. One thread at a time.
class StampOrder {
 public:
  /// Stamps that go back by more were set back.
  static constexpr double kSetBackSeconds = 2.0;

  /// True when the scan is to be used; its stamp is then above those before. `next` is the stamp
  /// of the scan behind it, if there is one.
  /// - A stamp that is not between those before and behind it, where these are in order, is no
  ///   time: it is a fault.
  /// - A scan a little older than the one before is out of order by more than ScanQueue can mend:
  ///   it is a fault.
  /// - A stamp as that of the scan before keeps its order: it moves on by 10 ms. The same scan
  ///   again, range for range, is a fault.
  /// - When the stamps go back by more than 2 s, the clock was set back: a new run begins. Its
  ///   stamps are moved to 10 minutes after the run before, so that a map takes it for a later run.
  /// - A jump ahead by more than 10 minutes begins a new run: the clock was set, or the recording
  ///   had a pause.
  [[nodiscard]] bool take(LogScan& scan, std::optional<double> next, LogFaults& faults);

  /// What was done to stamps, for people.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  void begin_run(LogScan& scan);
  void note_jump(LogScan& scan);
  [[nodiscard]] bool is_alone(double stamp, std::optional<double> next) const;
  [[nodiscard]] bool is_repeated(const LogScan& scan) const;

  std::optional<LogScan> last_;  ///< As recorded.
  double last_stamp_ = 0.0;      ///< As given out.
  double shift_ = 0.0;           ///< Of the current run [s].
  std::size_t equal_stamps_ = 0;
  std::size_t set_backs_ = 0;
  std::string first_set_back_;
  std::size_t jumps_ = 0;
  std::string first_jump_;
};

}  // namespace cornerfix::evaluation
