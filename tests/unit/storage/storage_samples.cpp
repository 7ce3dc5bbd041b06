#include "unit/storage/storage_samples.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>  // mkdtemp

#include <algorithm>
#include <bit>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>

namespace cornerfix::storage {
namespace {

namespace fs = std::filesystem;

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

template <typename T, typename Equal>
bool all_same(const std::vector<T>& a, const std::vector<T>& b, Equal equal) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), equal);
}

bool is_same(const Feature& a, const Feature& b) {
  return same(a.position.x(), b.position.x()) && same(a.position.y(), b.position.y()) &&
         same(a.turn_angle, b.turn_angle) && same(a.bisector, b.bisector) &&
         same(a.weight, b.weight) && a.count == b.count && a.convex == b.convex &&
         same(a.sigma_m, b.sigma_m);
}

}  // namespace

TempDirectory::TempDirectory() {
  std::string name = (fs::temp_directory_path() / "cornerfix-storage-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary directory");
  path_ = name;
}

TempDirectory::~TempDirectory() { fs::remove_all(path_); }

std::map<std::string, std::string> TempDirectory::snapshot() const {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(path_)) {
    files[entry.path().filename().string()] = read_bytes(entry.path());
  }
  return files;
}

std::string read_bytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::shared_ptr<SqliteDatabase> open_database(const fs::path& path, Synchronous synchronous) {
  auto database = SqliteDatabase::open(path, synchronous);
  if (!database) throw std::runtime_error(database.error().message);
  return *database;
}

LaserScan sample_scan(int seed) {
  LaserScan scan;
  scan.stamp = 1284.25 + seed;
  scan.angle_min = -2.35 + 0.001 * seed;
  scan.angle_increment = 0.0043633;
  scan.range_min = 0.02;
  scan.range_max = 30.0;
  for (int beam = 0; beam < 20; ++beam) {
    scan.ranges.push_back(1.0F + 0.37F * static_cast<float>((beam * 7 + seed) % 23));
  }
  using Limits = std::numeric_limits<float>;
  const std::vector<float> odd = {Limits::quiet_NaN(), Limits::infinity(), -0.0F,
                                  Limits::denorm_min(), Limits::max()};
  scan.ranges.insert(scan.ranges.end(), odd.begin(), odd.end());
  return scan;
}

PosedScan sample_key_frame(int seed) {
  return {sample_scan(seed), {0.2, -0.0, 3.1}, {0.5 * seed, -1.25, 0.01 * seed}};
}

std::vector<PosedScan> sample_key_frames(int count) {
  std::vector<PosedScan> key_frames;
  for (int i = 0; i < count; ++i) key_frames.push_back(sample_key_frame(i));
  return key_frames;
}

MapContent sample_content(int features) {
  MapContent content;
  content.descriptors.params = {0.25, 0.0872664625997165, 40.0};
  content.descriptors.offsets.push_back(0);
  for (int i = 0; i < features; ++i) {
    content.features.push_back(
        {{0.1 * i, -0.0}, 1.5 + 0.01 * i, -3.0, 0.7 * i, i + 1, i % 2 == 0, 0.01 * i});
    for (int other = 0; other < features; ++other) {
      if (other == i) continue;
      content.descriptors.entries.push_back({static_cast<std::uint16_t>(other * 3),
                                             static_cast<std::uint16_t>(65535 - i),
                                             static_cast<std::uint32_t>(other)});
    }
    content.descriptors.offsets.push_back(
        static_cast<std::uint32_t>(content.descriptors.entries.size()));
  }
  content.grid.resolution = 0.05;
  content.grid.T_map_grid = {-1.5, 2.25, 0.0};
  content.grid.width = 37;
  content.grid.height = 11;
  for (int i = 0; i < 37 * 11; ++i) content.grid.cells.push_back(static_cast<Cell>(i % 7 % 3));
  return content;
}

MapSketch sample_sketch(int seed) {
  MapSketch sketch;
  sketch.T_map_grid = {-1.5, 0.1 * seed, -0.0};
  sketch.free_area_m2 = 12.5 * seed;
  sketch.cell_m = 0.2;
  sketch.width = 7;
  sketch.height = 3;
  for (std::size_t i = 0; i < MapSketch::level_bytes(7, 3); ++i)
    sketch.levels.push_back(static_cast<std::uint8_t>(0xE4U + i));
  for (int i = 0; i < 3; ++i) {
    const float x = 0.1F * static_cast<float>(i + seed);
    sketch.corners.push_back({x, -0.0F, -3.0F, 1.5F, i % 2 == 0});
  }
  return sketch;
}

SubmapScan sample_submap_scan(std::uint64_t index, int seed) {
  return {index, sample_scan(seed), {0.1, 0.0, -0.0}, {0.3 * seed, 0.1, -0.2}};
}

LocalizerState sample_state(std::uint64_t first_index, int count, int seed) {
  LocalizerState state;
  for (int i = 0; i < count; ++i) {
    state.submap.push_back(std::make_shared<const SubmapScan>(
        sample_submap_scan(first_index + static_cast<std::uint64_t>(i), seed + i)));
  }
  state.next_index = first_index + static_cast<std::uint64_t>(count);
  state.scans = 1000 + static_cast<std::uint64_t>(seed);
  state.T_submap_base_link = {1.0, -0.0, 0.25 * seed};
  state.last_motion = {0.1, 0.01, -0.02};
  state.last_interval_s = 0.2;
  state.last_stamp = 99.5 + seed;
  state.last_T_odom_base_link = Pose2{7.0, 8.0, -3.1};
  state.status = Status::kLocalized;
  state.reason = Reason::kFewEvidence;
  state.confidence = 0.625;
  state.tracked_map = 2;
  state.T_map_submap = {4.0, 5.0, 6.0};
  state.misfits = 3;
  state.misfit_way_m = 0.7;
  state.tracking_covariance = {4e-4, 1e-5, 0.0, 1e-5, 9e-4, 0.0, 0.0, 0.0, 1e-5};
  state.usual_fit = 0.8;
  state.usual_share = 0.9;
  state.odometry_sums = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  state.epoch = 3;
  state.confirmed = true;
  state.distance_since_acceptance_m = 4.5;
  state.searched_at_m = 3.0;
  state.accepted_index = 12;
  state.region = StartRegion{.map = "office",
                             .center = {1.5, -2.0},
                             .radius_m = 3.0,
                             .yaw = 0.5,
                             .yaw_tolerance_rad = 0.25};
  return state;
}

bool is_same(const Pose2& a, const Pose2& b) {
  return same(a.x, b.x) && same(a.y, b.y) && same(a.yaw, b.yaw);
}

bool is_same(const LaserScan& a, const LaserScan& b) {
  return same(a.stamp, b.stamp) && same(a.angle_min, b.angle_min) &&
         same(a.angle_increment, b.angle_increment) && same(a.range_min, b.range_min) &&
         same(a.range_max, b.range_max) &&
         all_same(a.ranges, b.ranges, [](float x, float y) { return same(x, y); });
}

bool is_same(const PosedScan& a, const PosedScan& b) {
  return is_same(a.scan, b.scan) && is_same(a.T_base_link_laser, b.T_base_link_laser) &&
         is_same(a.T_map_base_link, b.T_map_base_link);
}

bool is_same(const std::vector<PosedScan>& a, const std::vector<PosedScan>& b) {
  return all_same(a, b, [](const PosedScan& x, const PosedScan& y) { return is_same(x, y); });
}

bool is_same(const std::vector<Feature>& a, const std::vector<Feature>& b) {
  return all_same(a, b, [](const Feature& x, const Feature& y) { return is_same(x, y); });
}

bool is_same(const DescriptorSet& a, const DescriptorSet& b) {
  return same(a.params.distance_resolution_m, b.params.distance_resolution_m) &&
         same(a.params.angle_resolution_rad, b.params.angle_resolution_rad) &&
         same(a.params.max_distance_m, b.params.max_distance_m) && a.offsets == b.offsets &&
         a.entries == b.entries;
}

bool is_same(const OccupancyGrid& a, const OccupancyGrid& b) {
  return same(a.resolution, b.resolution) && is_same(a.T_map_grid, b.T_map_grid) &&
         a.width == b.width && a.height == b.height && a.cells == b.cells;
}

bool is_same(const MapContent& a, const MapContent& b) {
  return is_same(a.features, b.features) && is_same(a.descriptors, b.descriptors) &&
         is_same(a.grid, b.grid);
}

bool is_same(const SubmapScan& a, const SubmapScan& b) {
  return a.index == b.index && is_same(a.scan, b.scan) &&
         is_same(a.T_base_link_laser, b.T_base_link_laser) &&
         is_same(a.T_submap_base_link, b.T_submap_base_link);
}

bool is_same(const LocalizerState& a, const LocalizerState& b) {
  const bool same_odometry =
      a.last_T_odom_base_link.has_value() == b.last_T_odom_base_link.has_value() &&
      is_same(a.last_T_odom_base_link.value_or(Pose2{}), b.last_T_odom_base_link.value_or(Pose2{}));
  return all_same(a.submap, b.submap,
                  [](const SubmapScanPtr& x, const SubmapScanPtr& y) { return is_same(*x, *y); }) &&
         a.next_index == b.next_index && a.scans == b.scans &&
         is_same(a.T_submap_base_link, b.T_submap_base_link) &&
         is_same(a.last_motion, b.last_motion) && same(a.last_interval_s, b.last_interval_s) &&
         a.last_stamp == b.last_stamp && same_odometry && a.status == b.status &&
         a.reason == b.reason && same(a.confidence, b.confidence) &&
         a.tracked_map == b.tracked_map && is_same(a.T_map_submap, b.T_map_submap) &&
         a.misfits == b.misfits && a.misfit_way_m == b.misfit_way_m &&
         a.tracking_covariance == b.tracking_covariance && a.usual_fit == b.usual_fit &&
         a.usual_share == b.usual_share && a.odometry_sums == b.odometry_sums &&
         a.epoch == b.epoch && a.confirmed == b.confirmed &&
         a.distance_since_acceptance_m == b.distance_since_acceptance_m &&
         a.searched_at_m == b.searched_at_m && a.accepted_index == b.accepted_index &&
         a.region == b.region;
}

bool is_same(const SessionRecord& a, const SessionRecord& b) {
  return a.id == b.id && a.robot == b.robot && a.created == b.created && a.maps == b.maps &&
         a.lidar_json == b.lidar_json && a.options_json == b.options_json &&
         a.expected_sequence == b.expected_sequence && a.last_answer == b.last_answer &&
         is_same(a.state, b.state) && a.map_ids == b.map_ids && a.last_batch == b.last_batch;
}

}  // namespace cornerfix::storage
