#include "core/src/features/feature_map.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <utility>

namespace cornerfix {

namespace {

constexpr double kSameDirection = 0.6;  // [rad]; the corners of a pillar are further apart

bool is_seen_again(const Feature& feature, const Feature& corner) {
  return feature.sigma_m > 0.0 && corner.sigma_m > 0.0 && feature.convex == corner.convex &&
         std::abs(wrap_angle(feature.bisector - corner.bisector)) < kSameDirection;
}

}  // namespace

std::optional<Error> validate(const FeatureMapParams& params) {
  if (!(params.suppression_radius_m > 0.0) || !std::isfinite(params.suppression_radius_m)) {
    return Error{ErrorCode::kInvalidArgument, "must be a finite length in metres above 0",
                 "suppression_radius_m"};
  }
  return std::nullopt;
}

FeatureMap::FeatureMap(FeatureMapParams params) : params_(params) {
  assert(!validate(params) && "suppression_radius_m must pass validate()");
}

void FeatureMap::insert(std::span<const Feature> corners) {
  ++scan_;
  for (const Feature& corner : corners) insert(corner);
}

std::vector<Feature> FeatureMap::repeated(int min_count) const {
  std::vector<Feature> kept;
  std::ranges::copy_if(features_, std::back_inserter(kept),
                       [&](const Feature& feature) { return feature.count >= min_count; });
  return kept;
}

FeatureMap::Cell FeatureMap::cell_of(const Point2& position, int columns_off, int rows_off) const {
  const auto index = [&](double coordinate) {
    return static_cast<std::int64_t>(std::floor(coordinate / params_.suppression_radius_m));
  };
  const auto column = static_cast<std::uint32_t>(index(position.x()) + columns_off);
  const auto row = static_cast<std::uint32_t>(index(position.y()) + rows_off);
  return (static_cast<Cell>(column) << 32) | row;
}

std::vector<std::size_t> FeatureMap::neighbors(const Point2& position) const {
  const double squared_radius = params_.suppression_radius_m * params_.suppression_radius_m;
  std::vector<std::pair<double, std::size_t>> near;
  for (const int columns_off : {-1, 0, 1}) {
    for (const int rows_off : {-1, 0, 1}) {
      const auto [begin, end] = cells_.equal_range(cell_of(position, columns_off, rows_off));
      for (auto it = begin; it != end; ++it) {
        const double squared = (features_[it->second].position - position).squaredNorm();
        if (squared <= squared_radius) near.emplace_back(squared, it->second);
      }
    }
  }
  std::ranges::sort(near);
  std::vector<std::size_t> indices;
  indices.reserve(near.size());
  for (const auto& [squared, index] : near) indices.push_back(index);
  return indices;
}

void FeatureMap::insert(const Feature& corner) {
  std::vector<std::size_t> near = neighbors(corner.position);
  const bool strongest = std::ranges::all_of(
      near, [&](std::size_t index) { return features_[index].weight < corner.weight; });
  const auto same = std::ranges::find_if(
      near, [&](std::size_t index) { return is_seen_again(features_[index], corner); });
  if (near.empty()) {
    append(corner);
  } else if (same != near.end()) {
    fuse(*same, corner);
  } else if (strongest) {
    absorb(std::move(near), corner);
  } else {
    count_scan(near.front());
  }
}

void FeatureMap::append(const Feature& corner) {
  cells_.emplace(cell_of(corner.position), features_.size());
  features_.push_back(corner);
  features_.back().count = 1;
  last_scan_.push_back(scan_);
}

void FeatureMap::fuse(std::size_t index, const Feature& corner) {
  Feature& feature = features_[index];
  const double known = 1.0 / (feature.sigma_m * feature.sigma_m);
  const double seen = 1.0 / (corner.sigma_m * corner.sigma_m);
  const double share = seen / (known + seen);
  feature.bisector =
      wrap_angle(feature.bisector + share * wrap_angle(corner.bisector - feature.bisector));
  feature.turn_angle = std::lerp(feature.turn_angle, corner.turn_angle, share);
  feature.weight = std::max(feature.weight, corner.weight);
  feature.sigma_m = 1.0 / std::sqrt(known + seen);
  count_scan(index);
  move(index, feature.position + share * (corner.position - feature.position));
}

/// Stays where it is if it came within the radius of another feature.
void FeatureMap::move(std::size_t index, const Point2& position) {
  const std::vector<std::size_t> near = neighbors(position);
  if (near.size() > 1 || (near.size() == 1 && near.front() != index)) return;
  forget_cell(index);
  features_[index].position = position;
  cells_.emplace(cell_of(position), index);
}

void FeatureMap::absorb(std::vector<std::size_t> weaker, const Feature& corner) {
  std::ranges::sort(weaker);
  const std::size_t kept = weaker.front();
  for (; weaker.size() > 1; weaker.pop_back()) {
    const std::size_t other = weaker.back();
    features_[kept].count += features_[other].count;
    last_scan_[kept] = std::max(last_scan_[kept], last_scan_[other]);
    remove(other);  // The last index first: what moves up has none of the remaining indices.
  }
  count_scan(kept);
  forget_cell(kept);
  const int count = std::min(features_[kept].count, scan_);  // Both may have been in one scan.
  features_[kept] = corner;
  features_[kept].count = count;
  cells_.emplace(cell_of(corner.position), kept);
}

void FeatureMap::remove(std::size_t index) {
  const std::size_t last = features_.size() - 1;
  forget_cell(index);
  if (index != last) {
    forget_cell(last);
    features_[index] = features_[last];
    last_scan_[index] = last_scan_[last];
    cells_.emplace(cell_of(features_[index].position), index);
  }
  features_.pop_back();
  last_scan_.pop_back();
}

void FeatureMap::forget_cell(std::size_t index) {
  const auto [begin, end] = cells_.equal_range(cell_of(features_[index].position));
  cells_.erase(std::find_if(begin, end, [&](const auto& item) { return item.second == index; }));
}

void FeatureMap::count_scan(std::size_t index) {
  if (last_scan_[index] == scan_) return;
  last_scan_[index] = scan_;
  ++features_[index].count;
}

}  // namespace cornerfix
