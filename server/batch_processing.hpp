/// \file  The scans of one batch, taken one after the other.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include <cornerfix/localizer.hpp>
#include <cornerfix/result.hpp>

#include "api/requests.hpp"

namespace cornerfix::server {

/// What a batch changed, for counting.
struct BatchEvents {
  std::size_t scans = 0;
  std::size_t fixes = 0;                            ///< Times that it became localized.
  std::size_t lost = 0;                             ///< Times that it became lost.
  std::map<Withdrawal, std::size_t> withdrawals{};  ///< Poses withdrawn, by cause.
  std::size_t odometry_ignored = 0;                 ///< Scans whose odometry was ignored.
  Status status = Status::kCollecting;              ///< Of the answer.
  Reason reason = Reason::kNone;                    ///< Of the answer.
  StepTimes times{};                                ///< Of all scans.
  /// From the first scan of a search to the scan that localized, by their stamps.
  std::vector<double> times_to_localization_s{};
};

struct ProcessedBatch {
  Answer answer;  ///< To the last scan, with the times of all.
  BatchEvents events;
};

/// Called before each scan but the first, with the answer to the one before it.
using BetweenScans = std::function<Result<void>(const Answer&)>;

/// `status` is that before the batch. `search_begin` is the stamp of the first scan of a search,
/// while it lasts. Fails only when `between_scans` does.
[[nodiscard]] Result<ProcessedBatch> process_batch(Localizer& localizer, Status status,
                                                   std::span<const RobotScan> scans,
                                                   std::optional<double>& search_begin,
                                                   const BetweenScans& between_scans = {});

/// Stamps within a batch increase already; a batch must also begin after the one before it.
/// Scans of two lidars may have the same stamp.
[[nodiscard]] std::optional<Error> check_stamp(const RobotScan& first,
                                               std::optional<double> last_stamp,
                                               const api::Lidars& lidars);

}  // namespace cornerfix::server
