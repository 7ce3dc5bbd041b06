#include "frames/robot_odometry.hpp"

#include <algorithm>
#include <iterator>

namespace cornerfix {

namespace {

using Ancestor = FrameTree::Ancestor;

bool is_base(const std::string& frame) {
  return is_frame_called(frame, "base") || frame.find("footprint") != std::string::npos;
}

std::optional<RobotOdometry::Found> in_tf(const Ancestor& ancestor) {
  if (!ancestor.T_ancestor_frame) return std::nullopt;
  return RobotOdometry::Found{*ancestor.T_ancestor_frame, ""};
}

}  // namespace

void RobotOdometry::add(const StampedTransform& T_odom_child) {
  parent_ = T_odom_child.parent;
  child_ = T_odom_child.child.empty() ? "base_link" : T_odom_child.child;
  track_.add(T_odom_child.stamp, T_odom_child.T_parent_child);
}

std::optional<RobotOdometry::Found> RobotOdometry::find(const FrameTree& frames,
                                                        const std::string& frame,
                                                        double stamp) const {
  const Ancestors ancestors = frames.ancestors(frame, stamp);
  if (!is_chosen_) {
    if (const Ancestor* odometry = odometry_frame(ancestors)) return in_tf(*odometry);
  }
  if (!child_.empty()) return from_messages(frames, ancestors, stamp);
  if (is_chosen_) return std::nullopt;
  if (const auto below = frames.find_below("odom", frame, stamp)) return in_tf(*below);
  const Ancestor* root = root_above_base(ancestors);
  return root != nullptr ? in_tf(*root) : std::nullopt;
}

const Ancestor* RobotOdometry::odometry_frame(const Ancestors& ancestors) const {
  const auto found = std::ranges::find_if(ancestors, [&](const Ancestor& ancestor) {
    return is_frame_called(ancestor.name, "odom") ||
           (!parent_.empty() && ancestor.name == parent_ && !is_frame_called(parent_, "map"));
  });
  return found == ancestors.end() ? nullptr : &*found;
}

const Ancestor* RobotOdometry::root_above_base(const Ancestors& ancestors) {
  const auto map = std::ranges::find_if(
      ancestors, [](const Ancestor& ancestor) { return is_frame_called(ancestor.name, "map"); });
  // A transform that never changes may be a part of the robot that is published again and again.
  const auto moved = std::find_if(std::make_reverse_iterator(map), ancestors.rend(),
                                  [](const Ancestor& ancestor) { return ancestor.has_moved; });
  return moved == ancestors.rend() || is_base(moved->name) ? nullptr : &*moved;
}

std::optional<RobotOdometry::Found> RobotOdometry::from_messages(const FrameTree& frames,
                                                                 const Ancestors& ancestors,
                                                                 double stamp) const {
  const auto T_odom_child = track_.at(stamp);
  if (!T_odom_child) return std::nullopt;
  const std::string& frame = ancestors.front().name;
  if (const auto T_child_frame = frames.between(child_, frame, stamp)) {
    return Found{{T_odom_child->transform * T_child_frame->transform,
                  T_odom_child->is_final && T_child_frame->is_final},
                 ""};
  }
  const Ancestor& root = ancestors.back();
  const bool is_elsewhere =
      is_frame_called(root.name, "map") || std::ranges::any_of(ancestors, &Ancestor::has_moved);
  if (is_elsewhere || !root.T_ancestor_frame) return std::nullopt;
  std::string note = "no transform from " + child_ + " to " + frame + ": ";
  note += root.name == frame ? "the laser is taken to be at " + child_
                             : root.name + " is taken to be " + child_;
  // A transform that is still to come may connect them.
  return Found{{T_odom_child->transform * root.T_ancestor_frame->transform, false},
               std::move(note)};
}

}  // namespace cornerfix
