#include "cli/bag/frame_tree.hpp"

#include <algorithm>
#include <cmath>

namespace cornerfix::cli {

namespace {

constexpr std::size_t kMaxFrames = 10000;
constexpr std::size_t kMaxDepth = 100;      // a cycle is longer
constexpr std::size_t kMaxSamples = 20000;  // of a transform
constexpr double kKeptSeconds = 20.0;
constexpr double kMaxGapSeconds = 1.0;
constexpr double kHeldSeconds = 0.1;

bool is_called(std::string_view frame, std::string_view name) {
  return frame.substr(frame.rfind('/') + 1).starts_with(name);
}

Eigen::Isometry3d interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                              double share) {
  Eigen::Isometry3d between = Eigen::Isometry3d::Identity();
  between.translation() = a.translation() + share * (b.translation() - a.translation());
  const Eigen::Quaterniond from(a.linear());
  const Eigen::Quaterniond to(b.linear());
  between.linear() = from.slerp(share, to).toRotationMatrix();
  return between;
}

}  // namespace

void FrameTree::add(const StampedTransform& transform, Origin origin) {
  if (transform.child.empty() || transform.child == transform.parent) return;
  const auto known = edges_.find(transform.child);
  if (known == edges_.end() && edges_.size() >= kMaxFrames) return;
  if (known != edges_.end() && origin == Origin::kOdometry && known->second.origin != origin) {
    return;
  }
  Edge& edge = edges_[transform.child];
  if (edge.parent != transform.parent || edge.origin != origin || origin == Origin::kStatic) {
    edge = {transform.parent, origin, {}};
  }
  if (!edge.samples.empty()) {
    const double last = edge.samples.back().stamp;
    if (transform.stamp < last - kKeptSeconds) edge.samples.clear();
    if (transform.stamp <= last && !edge.samples.empty()) return;
  }
  edge.samples.push_back({transform.stamp, transform.T_parent_child});
  while (edge.samples.front().stamp < transform.stamp - kKeptSeconds ||
         edge.samples.size() > kMaxSamples) {
    edge.samples.pop_front();
  }
}

std::optional<FrameTree::Found> FrameTree::at(const Edge& edge, double stamp) {
  if (edge.samples.empty()) return std::nullopt;
  if (edge.origin == Origin::kStatic) return Found{edge.samples.back().T_parent_child, true};
  const auto after =
      std::lower_bound(edge.samples.begin(), edge.samples.end(), stamp,
                       [](const Sample& sample, double time) { return sample.stamp < time; });
  if (after == edge.samples.end()) {
    const Sample& last = edge.samples.back();
    if (stamp - last.stamp > kHeldSeconds) return std::nullopt;
    return Found{last.T_parent_child, false};
  }
  if (after->stamp == stamp) return Found{after->T_parent_child, true};
  if (after == edge.samples.begin()) return std::nullopt;
  const Sample& before = *std::prev(after);
  const double gap = after->stamp - before.stamp;
  if (gap > kMaxGapSeconds) return std::nullopt;
  const double share = (stamp - before.stamp) / gap;
  return Found{interpolate(before.T_parent_child, after->T_parent_child, share), true};
}

std::optional<FrameTree::Found> FrameTree::find(std::string_view ancestor, const std::string& frame,
                                                double stamp) const {
  Found found{Eigen::Isometry3d::Identity(), true};
  std::string_view here = frame;
  for (std::size_t depth = 0; depth < kMaxDepth; ++depth) {
    if (is_called(here, ancestor)) return found;
    const auto edge = edges_.find(std::string(here));
    if (edge == edges_.end()) return std::nullopt;
    const auto step = at(edge->second, stamp);
    if (!step) return std::nullopt;
    found.T_ancestor_frame = step->T_ancestor_frame * found.T_ancestor_frame;
    found.is_final = found.is_final && step->is_final;
    here = edge->second.parent;
  }
  return std::nullopt;
}

}  // namespace cornerfix::cli
