#include "server/mapping_batch.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <limits>
#include <string>
#include <unordered_set>
#include <utility>

namespace cornerfix::server {
namespace {

void unify_no_returns(LaserScan& scan) {
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!scan.has_return(beam)) scan.ranges[beam] = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace

std::optional<Error> mixed(const storage::MapInfo& map, bool scans_have_poses) {
  if (map.key_frame_count == 0 || map.drifts != scans_have_poses) return std::nullopt;
  return Error{ErrorCode::kConflict,
               map.drifts
                   ? "the map is made from scans without poses: these have poses. Give the "
                     "map an optimised trajectory first, or another name"
                   : "the map is made from scans at poses: these have none. Give them poses in its "
                     "frame, as a robot that is localized in it has, or another map",
               "/scans"};
}

template <typename Scan>
std::vector<const Scan*> new_scans(std::span<const Scan> scans, const std::vector<bool>& known) {
  std::vector<const Scan*> fresh;
  std::unordered_set<double> stamps;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!known[i] && stamps.insert(scans[i].scan.stamp).second) fresh.push_back(&scans[i]);
  }
  return fresh;
}

template std::vector<const PosedScan*> new_scans(std::span<const PosedScan> scans,
                                                 const std::vector<bool>& known);
template std::vector<const RobotScan*> new_scans(std::span<const RobotScan> scans,
                                                 const std::vector<bool>& known);

std::optional<Error> too_late(std::span<const RobotScan* const> fresh,
                              std::span<const RobotScan> scans, const Mapper& mapper) {
  if (fresh.empty() || mapper.key_frames().empty()) return std::nullopt;
  const double last = mapper.key_frames().back().scan.stamp;
  const auto late = std::ranges::find_if(
      fresh, [last](const RobotScan* scan) { return scan->scan.stamp <= last; });
  if (late == fresh.end()) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("must be later than the last key frame's {}, since scans without pose "
                           "are one drive",
                           last),
               "/scans/" + std::to_string(*late - scans.data()) + "/stamp"};
}

PosedScan posed_by(LidarOdometry& /*odometry*/, const PosedScan& scan) {
  PosedScan posed = scan;
  unify_no_returns(posed.scan);
  return posed;
}

PosedScan posed_by(LidarOdometry& odometry, const RobotScan& scan) {
  return posed_by(odometry, PosedScan{scan.scan, scan.T_base_link_laser, odometry.process(scan)});
}

}  // namespace cornerfix::server
