#include <cornerfix/mapper.hpp>

#include <cmath>
#include <string>
#include <utility>

#include "core/src/features/feature_history.hpp"
#include "core/src/map/mapping_drive.hpp"
#include "core/src/map/occupancy_mapping.hpp"
#include "core/src/scan/finite_scan.hpp"

namespace cornerfix {

std::optional<Error> validate(const MapperParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.key_frame_distance_m >= 0.0 && params.key_frame_distance_m <= 100.0)) {
    return broken("key_frame_distance_m", "must be in [0, 100] m");
  }
  if (!(params.key_frame_angle_rad >= 0.0 && params.key_frame_angle_rad <= std::numbers::pi)) {
    return broken("key_frame_angle_rad", "must be in [0, pi] rad");
  }
  if (params.min_feature_count < 1) return broken("min_feature_count", "must be at least 1");
  if (!(params.features.suppression_radius_m > 0.0 &&
        params.features.suppression_radius_m <= 10.0)) {
    return broken("features.suppression_radius_m", "must be in (0, 10] m");
  }
  if (auto error = validate(params.grid)) {
    error->field = "grid." + error->field;
    return error;
  }
  if (auto error = validate(params.descriptors)) {
    error->field = "descriptors." + error->field;
    return error;
  }
  return std::nullopt;
}

Mapper::Mapper(MapperParams params)
    : params_(params),
      features_(std::make_unique<FeatureHistory>(params.features, params.min_feature_count)) {}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;

std::optional<Error> Mapper::reject(const PosedScan& scan) const {
  const Pose2& pose = scan.T_map_base_link;
  if (!has_finite_geometry(scan.scan, scan.T_base_link_laser) ||
      !std::isfinite(pose.x + pose.y + pose.yaw)) {
    return Error{ErrorCode::kInvalidArgument,
                 "expected finite numbers for pose, mount, angles and range_min", "scan"};
  }
  Bounds all = bounds_of(scan, params_.grid);
  if (bounds_) all.extend(*bounds_);
  const Point2 size = (all.max - all.min) / params_.grid.resolution_m;
  if (size.x() * size.y() <= kMaxCells) return std::nullopt;
  return Error{ErrorCode::kInvalidArgument,
               "the map would grow to " +
                   std::to_string(static_cast<long long>((all.max - all.min).x())) + " x " +
                   std::to_string(static_cast<long long>((all.max - all.min).y())) +
                   " m, more than its grid can hold at " +
                   std::to_string(params_.grid.resolution_m) + " m/cell",
               "pose"};
}

bool Mapper::is_key_frame(const PosedScan& scan) const {
  if (key_frames_.empty()) return true;
  const Pose2& last = key_frames_.back().T_map_base_link;
  return distance(last, scan.T_map_base_link) >= params_.key_frame_distance_m ||
         angle_between(last, scan.T_map_base_link) >= params_.key_frame_angle_rad;
}

void Mapper::add(PosedScan key_frame) {
  const Pose2 T_map_laser = key_frame.T_map_base_link * key_frame.T_base_link_laser;
  std::vector<Feature> corners = extract_corners(key_frame.scan, params_.extractor);
  for (Feature& corner : corners) corner = transformed(T_map_laser, corner);
  if (!key_frames_.empty() && begins_drive(key_frames_.back(), key_frame)) features_->begin_drive();
  features_->insert(corners, key_frame.scan, T_map_laser);
  const Bounds seen = bounds_of(key_frame, params_.grid);
  if (bounds_) {
    bounds_->extend(seen);
  } else {
    bounds_ = seen;
  }
  key_frames_.push_back(std::move(key_frame));
}

std::size_t Mapper::feature_count() const { return features_->repeated().size(); }

MapContent Mapper::build() const {
  MapContent content;
  content.features = features_->repeated();
  content.descriptors = describe(content.features, params_.descriptors);
  content.grid = build_occupancy_grid(key_frames_, params_.grid);
  return content;
}

}  // namespace cornerfix
