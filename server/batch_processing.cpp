#include "server/batch_processing.hpp"

#include <spdlog/fmt/fmt.h>

namespace cornerfix::server {
namespace {

void add(StepTimes& sum, const StepTimes& times) {
  sum.odometry_ms += times.odometry_ms;
  sum.extract_ms += times.extract_ms;
  sum.match_ms += times.match_ms;
  sum.verify_ms += times.verify_ms;
  sum.track_ms += times.track_ms;
  sum.total_ms += times.total_ms;
}

}  // namespace

Result<ProcessedBatch> process_batch(Localizer& localizer, Status status,
                                     std::span<const RobotScan> scans,
                                     std::optional<double>& search_begin,
                                     const BetweenScans& between_scans) {
  ProcessedBatch batch;
  StepTimes times;
  for (const RobotScan& scan : scans) {
    if (status != Status::kLocalized && !search_begin) search_begin = scan.scan.stamp;
    if (between_scans && batch.events.scans > 0) {
      if (auto ready = between_scans(batch.answer); !ready) return ready.error();
    }
    batch.answer = localizer.process(scan);
    add(times, batch.answer.times);
    ++batch.events.scans;
    if (batch.answer.withdrawal != Withdrawal::kNone)
      ++batch.events.withdrawals[batch.answer.withdrawal];
    batch.events.odometry_ignored += batch.answer.odometry == OdometryUse::kIgnored ? 1U : 0U;
    if (batch.answer.status != status) {
      batch.events.fixes += batch.answer.status == Status::kLocalized ? 1U : 0U;
      batch.events.lost += batch.answer.status == Status::kLost ? 1U : 0U;
    }
    status = batch.answer.status;
    if (status == Status::kLocalized && search_begin) {
      batch.events.times_to_localization_s.push_back(scan.scan.stamp - *search_begin);
      search_begin.reset();
    }
  }
  batch.answer.times = times;
  batch.events.status = status;
  batch.events.reason = batch.answer.reason;
  batch.events.times = times;
  return batch;
}

std::optional<Error> check_stamp(const RobotScan& first, std::optional<double> last_stamp,
                                 const api::Lidars& lidars) {
  if (!last_stamp || first.scan.stamp > *last_stamp) return std::nullopt;
  if (lidars.by_name.size() > 1 && first.scan.stamp == *last_stamp) return std::nullopt;
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("stamp {} is not after {}, the session's last", first.scan.stamp, *last_stamp),
      "/scans/0/stamp"};
}

}  // namespace cornerfix::server
