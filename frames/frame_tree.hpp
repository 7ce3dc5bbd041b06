/// \file  Where the frames of a robot were at any recent time: what tf knows.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "frames/stamped_transform.hpp"
#include "frames/transform_track.hpp"

namespace cornerfix {

/// Whether a frame's name begins with `name` after its last '/': "odom" finds
/// "robot1/odom_combined".
[[nodiscard]] bool is_frame_called(std::string_view frame, std::string_view name);

/// Keeps the last seconds of each transform. Not synchronised.
class FrameTree {
 public:
  enum class Origin {
    kStatic,  ///< Holds at all times.
    kTf,      ///< Holds at its stamp: see TransformTrack.
  };

  /// A frame has one parent. While that is published, a second one (`map` beside `odom`, or the
  /// `base_footprint` of a URDF above and below `base_link`) is put below the frame. It is passed
  /// over if it has a parent itself.
  void add(const StampedTransform& transform, Origin origin);

  /// A frame, or one above it.
  struct Ancestor {
    std::string name;
    std::optional<FoundTransform> T_ancestor_frame;  ///< Nothing when it is not known at the stamp.
    bool has_moved = false;  ///< The frame below it in this one, since the bag began.
  };

  /// The frame itself, then one after the other up to the root.
  [[nodiscard]] std::vector<Ancestor> ancestors(const std::string& frame, double stamp) const;

  /// T_called_frame of the nearest ancestor that is called so, or else of a frame below: see
  /// find_below(). Nothing when there is none, or not at that stamp.
  [[nodiscard]] std::optional<FoundTransform> find(std::string_view name, const std::string& frame,
                                                   double stamp) const;

  /// A frame that is called so and moves below an ancestor of `frame`, as if it were an ancestor.
  /// A frame has one parent only. So a second odometry (kiss_icp, viso2, robot_localization with
  /// its inverse transform) puts its frame below the base. The first by name.
  [[nodiscard]] std::optional<Ancestor> find_below(std::string_view name, const std::string& frame,
                                                   double stamp) const;

  /// T_target_source by way of the first frame above both, or nothing.
  [[nodiscard]] std::optional<FoundTransform> between(const std::string& target,
                                                      const std::string& source,
                                                      double stamp) const;

 private:
  /// From a child to its parent.
  struct Edge {
    std::string parent;
    Origin origin = Origin::kTf;
    Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();  ///< When static.
    TransformTrack track;                                              ///< Else.
  };

  [[nodiscard]] bool has_another_parent(const StampedTransform& transform) const;
  [[nodiscard]] bool is_below(const std::string& frame, const std::string& above) const;
  void insert(const StampedTransform& transform, Origin origin);

  std::unordered_map<std::string, Edge> edges_;  ///< By child.
};

}  // namespace cornerfix
