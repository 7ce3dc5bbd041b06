/// \file  Where the frames of a robot were at any recent time: what tf knows.
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "cli/bag/ros_messages.hpp"

namespace cornerfix::cli {

/// Keeps the last seconds of each transform. Not synchronised.
class FrameTree {
 public:
  enum class Origin {
    kStatic,    ///< Holds at all times.
    kTf,        ///< Holds at its stamp.
    kOdometry,  ///< As kTf, but gives way to tf where that knows the same child.
  };

  /// What stamps from the same child must be younger than; an older one is passed over, unless the
  /// clock was set back.
  void add(const StampedTransform& transform, Origin origin);

  struct Found {
    Eigen::Isometry3d T_ancestor_frame;
    bool is_final;  ///< No transform that is still to come can change it.
  };

  /// The transform at `stamp` to the nearest ancestor whose name, without what precedes the last
  /// '/', begins with `ancestor` ("map"; "odom" finds "odom_combined"). Interpolated between stamps
  /// at most a second apart; beyond the last one it holds for a tenth of a second. Nothing when
  /// there is no such ancestor or no such stamp.
  [[nodiscard]] std::optional<Found> find(std::string_view ancestor, const std::string& frame,
                                          double stamp) const;

  [[nodiscard]] bool knows(const std::string& frame) const { return edges_.contains(frame); }

 private:
  struct Sample {
    double stamp;
    Eigen::Isometry3d T_parent_child;
  };

  /// From a child to its parent.
  struct Edge {
    std::string parent;
    Origin origin = Origin::kTf;
    std::deque<Sample> samples;  ///< By stamp; one when static.
  };

  [[nodiscard]] static std::optional<Found> at(const Edge& edge, double stamp);

  std::unordered_map<std::string, Edge> edges_;  ///< By child.
};

}  // namespace cornerfix::cli
