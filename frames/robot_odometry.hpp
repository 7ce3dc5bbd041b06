/// \file  Which odometry a bag has for its laser, from tf or from nav_msgs/Odometry.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "frames/frame_tree.hpp"

namespace cornerfix {

/// Not synchronised.
class RobotOdometry {
 public:
  /// \param is_chosen  The messages were asked for: tf is used for the laser's place only.
  explicit RobotOdometry(bool is_chosen) : is_chosen_(is_chosen) {}

  /// A message of the topic in use.
  void add(const StampedTransform& T_odom_child);

  struct Found {
    FoundTransform T_odom_frame;
    std::string note;  ///< What was assumed, for people; may be empty.
  };

  /// The first of:
  /// 1. a frame above `frame` that is called odom, or as the parent frame of the messages;
  /// 2. the messages, by way of their child frame. When tf does not connect that frame with
  ///    `frame`, it is taken to be the root above `frame`;
  /// 3. a frame called odom below the base;
  /// 4. the uppermost frame (below `map`, if that is above) in which the laser has moved.
  [[nodiscard]] std::optional<Found> find(const FrameTree& frames, const std::string& frame,
                                          double stamp) const;

  [[nodiscard]] const std::string& parent() const { return parent_; }
  [[nodiscard]] const std::string& child() const { return child_; }

 private:
  using Ancestors = std::vector<FrameTree::Ancestor>;

  [[nodiscard]] const FrameTree::Ancestor* odometry_frame(const Ancestors& ancestors) const;
  [[nodiscard]] static const FrameTree::Ancestor* root_above_base(const Ancestors& ancestors);
  [[nodiscard]] std::optional<Found> from_messages(const FrameTree& frames,
                                                   const Ancestors& ancestors, double stamp) const;

  bool is_chosen_;
  TransformTrack track_;
  std::string parent_;
  std::string child_;  ///< Empty: no message so far.
};

}  // namespace cornerfix
