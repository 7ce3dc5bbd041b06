#include "server/trajectory_poses.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace cornerfix::server {
namespace {

constexpr double kStampToleranceS = 1e-3;
constexpr std::size_t kMaxStampsTold = 20;

const api::StampedPose* nearest(const std::vector<api::StampedPose>& poses, double stamp) {
  const auto after = std::ranges::lower_bound(poses, stamp, {}, &api::StampedPose::stamp);
  const api::StampedPose* best = after == poses.end() ? nullptr : &*after;
  if (after != poses.begin()) {
    const api::StampedPose* before = &*std::prev(after);
    if (best == nullptr || stamp - before->stamp < best->stamp - stamp) best = before;
  }
  const bool is_near = best != nullptr && std::abs(best->stamp - stamp) <= kStampToleranceS;
  return is_near ? best : nullptr;
}

Error uncovered_key_frames(const std::vector<double>& missing, std::size_t key_frames) {
  std::string message = "no pose within 1 ms of " + std::to_string(missing.size()) + " of " +
                        std::to_string(key_frames) + " key frames, at stamps ";
  const std::size_t told = std::min(missing.size(), kMaxStampsTold);
  for (std::size_t i = 0; i < told; ++i) {
    message += fmt::format("{}{}", i == 0 ? "" : ", ", missing[i]);
  }
  if (told < missing.size()) message += ", …";
  return {ErrorCode::kInvalidArgument, message, "/poses"};
}

}  // namespace

Result<std::vector<Pose2>> poses_of(const std::vector<PosedScan>& key_frames,
                                    std::span<const api::StampedPose> given) {
  std::vector<api::StampedPose> poses(given.begin(), given.end());
  std::ranges::sort(poses, {}, &api::StampedPose::stamp);
  const auto is_contradiction = [](const api::StampedPose& a, const api::StampedPose& b) {
    return a.stamp == b.stamp && a.T_map_base_link != b.T_map_base_link;
  };
  const auto twice = std::ranges::adjacent_find(poses, is_contradiction);
  if (twice != poses.end()) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("two poses at stamp {} that differ, expected one", twice->stamp),
                 "/poses"};
  }
  std::vector<Pose2> moved;
  std::vector<double> missing;
  for (const PosedScan& key_frame : key_frames) {
    const api::StampedPose* pose = nearest(poses, key_frame.scan.stamp);
    if (pose != nullptr) {
      moved.push_back(pose->T_map_base_link);
    } else {
      missing.push_back(key_frame.scan.stamp);
    }
  }
  if (!missing.empty()) return uncovered_key_frames(missing, key_frames.size());
  return moved;
}

}  // namespace cornerfix::server
