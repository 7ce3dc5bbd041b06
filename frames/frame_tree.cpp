#include "frames/frame_tree.hpp"

#include <algorithm>
#include <cmath>

namespace cornerfix {

namespace {

constexpr std::size_t kMaxFrames = 10000;
constexpr std::size_t kMaxDepth = 100;  // a cycle is longer

}  // namespace

bool is_frame_called(std::string_view frame, std::string_view name) {
  return frame.substr(frame.rfind('/') + 1).starts_with(name);
}

void FrameTree::add(const StampedTransform& transform, Origin origin) {
  if (transform.child.empty() || transform.child == transform.parent) return;
  if (!has_another_parent(transform)) return insert(transform, origin);
  const auto above = edges_.find(transform.parent);
  if (above != edges_.end() && above->second.parent != transform.child) return;
  if (is_below(transform.child, transform.parent)) return;  // it would close a cycle
  insert({transform.stamp, transform.child, transform.parent, transform.T_parent_child.inverse()},
         origin);
}

bool FrameTree::has_another_parent(const StampedTransform& transform) const {
  constexpr double kAliveSeconds = 1.0;
  const auto found = edges_.find(transform.child);
  if (found == edges_.end() || found->second.parent == transform.parent) return false;
  const Edge& edge = found->second;
  if (edge.origin == Origin::kStatic) return true;
  const auto last = edge.track.last_stamp();
  return last && std::abs(transform.stamp - *last) <= kAliveSeconds;
}

bool FrameTree::is_below(const std::string& frame, const std::string& above) const {
  auto edge = edges_.find(frame);
  for (std::size_t depth = 0; depth < kMaxDepth && edge != edges_.end(); ++depth) {
    if (edge->second.parent == above) return true;
    edge = edges_.find(edge->second.parent);
  }
  return false;
}

void FrameTree::insert(const StampedTransform& transform, Origin origin) {
  if (edges_.size() >= kMaxFrames && !edges_.contains(transform.child)) return;
  Edge& edge = edges_[transform.child];
  if (edge.parent != transform.parent || edge.origin != origin) {
    edge = {transform.parent, origin, Eigen::Isometry3d::Identity(), {}};
  }
  if (origin == Origin::kStatic) {
    edge.T_parent_child = transform.T_parent_child;
  } else {
    edge.track.add(transform.stamp, transform.T_parent_child);
  }
}

std::vector<FrameTree::Ancestor> FrameTree::ancestors(const std::string& frame,
                                                      double stamp) const {
  std::vector<Ancestor> chain{{frame, FoundTransform{}, false}};
  while (chain.size() < kMaxDepth) {
    const auto found = edges_.find(chain.back().name);
    if (found == edges_.end()) break;
    const Edge& edge = found->second;
    const auto step = edge.origin == Origin::kStatic ? FoundTransform{edge.T_parent_child, true}
                                                     : edge.track.at(stamp);
    Ancestor above{edge.parent, std::nullopt, edge.track.has_moved()};
    if (const auto& below = chain.back().T_ancestor_frame; below && step) {
      above.T_ancestor_frame = {step->transform * below->transform,
                                step->is_final && below->is_final};
    }
    chain.push_back(std::move(above));
  }
  return chain;
}

std::optional<FoundTransform> FrameTree::find(std::string_view name, const std::string& frame,
                                              double stamp) const {
  for (const Ancestor& above : ancestors(frame, stamp)) {
    if (is_frame_called(above.name, name)) return above.T_ancestor_frame;
  }
  const auto below = find_below(name, frame, stamp);
  return below ? below->T_ancestor_frame : std::nullopt;
}

std::optional<FrameTree::Ancestor> FrameTree::find_below(std::string_view name,
                                                         const std::string& frame,
                                                         double stamp) const {
  const std::string root = ancestors(frame, stamp).back().name;
  const std::string* first = nullptr;
  for (const auto& [child, edge] : edges_) {
    const bool is_wanted = edge.origin == Origin::kTf && is_frame_called(child, name);
    if (!is_wanted || (first != nullptr && *first < child)) continue;
    if (ancestors(child, stamp).back().name == root) first = &child;
  }
  if (first == nullptr) return std::nullopt;
  return Ancestor{*first, between(*first, frame, stamp), true};
}

std::optional<FoundTransform> FrameTree::between(const std::string& target,
                                                 const std::string& source, double stamp) const {
  const std::vector<Ancestor> above_target = ancestors(target, stamp);
  for (const Ancestor& above_source : ancestors(source, stamp)) {
    const auto common = std::ranges::find(above_target, above_source.name, &Ancestor::name);
    if (common == above_target.end()) continue;
    const auto& T_common_target = common->T_ancestor_frame;
    const auto& T_common_source = above_source.T_ancestor_frame;
    if (!T_common_target || !T_common_source) return std::nullopt;
    return FoundTransform{T_common_target->transform.inverse() * T_common_source->transform,
                          T_common_target->is_final && T_common_source->is_final};
  }
  return std::nullopt;
}

}  // namespace cornerfix
