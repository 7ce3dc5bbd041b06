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

  void add(const StampedTransform& transform, Origin origin);

  /// A frame, or one above it.
  struct Ancestor {
    std::string name;
    std::optional<FoundTransform> T_ancestor_frame;  ///< Nothing when it is not known at the stamp.
    bool has_moved = false;  ///< The frame below it in this one, since the bag began.
  };

  /// The frame itself, then one after the other up to the root.
  [[nodiscard]] std::vector<Ancestor> ancestors(const std::string& frame, double stamp) const;

  /// T_ancestor_frame of the nearest ancestor that is called so. Nothing when there is none, or not
  /// at that stamp.
  [[nodiscard]] std::optional<FoundTransform> find(std::string_view ancestor,
                                                   const std::string& frame, double stamp) const;

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

  std::unordered_map<std::string, Edge> edges_;  ///< By child.
};

}  // namespace cornerfix
