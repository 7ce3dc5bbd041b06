#include "core/src/local_map/view.hpp"

#include <algorithm>
#include <iterator>

namespace cornerfix {

View view_from(const Submap& submap, const Pose2& T_submap_base_link) {
  const Pose2 T_base_link_submap = inverse(T_submap_base_link);
  const auto moved = [&](const std::vector<Point2>& points) {
    std::vector<Point2> here;
    here.reserve(points.size());
    const double c = std::cos(T_base_link_submap.yaw);
    const double s = std::sin(T_base_link_submap.yaw);
    for (const Point2& p : points) {
      here.emplace_back(T_base_link_submap.x + c * p.x() - s * p.y(),
                        T_base_link_submap.y + s * p.x() + c * p.y());
    }
    return here;
  };
  const Evidence& seen = submap.evidence();
  View view{{moved(seen.ends), moved(seen.free), moved(seen.origins), seen.end_blocks,
             seen.free_blocks, seen.blocks, seen.independent_hits},
            {},
            {}};
  for (const Pose2& T_submap_then : submap.poses())
    view.way.push_back((T_base_link_submap * T_submap_then).translation());
  for (const Feature& corner : submap.features())
    view.corners.push_back(transformed(T_base_link_submap, corner));
  return view;
}

View mirrored(View view) {
  for (std::vector<Point2>* points :
       {&view.evidence.ends, &view.evidence.free, &view.evidence.origins, &view.way}) {
    for (Point2& p : *points) p.y() = -p.y();
  }
  view.corners.clear();
  return view;
}

}  // namespace cornerfix
