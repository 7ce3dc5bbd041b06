/// \file  Content to store, equality of what core leaves without one, and files for one test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <cornerfix/localizer.hpp>
#include <cornerfix/mapper.hpp>

#include "storage/session_store.hpp"
#include "storage/sqlite/sqlite_database.hpp"

namespace cornerfix::storage {

/// A directory that is empty at first and gone after the test.
class TempDirectory {
 public:
  TempDirectory();
  ~TempDirectory();
  TempDirectory(const TempDirectory&) = delete;
  TempDirectory& operator=(const TempDirectory&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return path_ / name;
  }
  /// Every file in it with its bytes.
  [[nodiscard]] std::map<std::string, std::string> snapshot() const;

 private:
  std::filesystem::path path_;
};

[[nodiscard]] std::string read_bytes(const std::filesystem::path& path);
void write_bytes(const std::filesystem::path& path, const std::string& bytes);

/// Opens or creates; fails the test when that fails.
[[nodiscard]] std::shared_ptr<SqliteDatabase> open_database(
    const std::filesystem::path& path, Synchronous synchronous = Synchronous::kNormal);

/// Values that differ from `seed` to `seed`, with the bits that are easily lost: NaN, infinity,
/// negative zero, the smallest and largest numbers.
[[nodiscard]] LaserScan sample_scan(int seed);
[[nodiscard]] PosedScan sample_key_frame(int seed);
[[nodiscard]] std::vector<PosedScan> sample_key_frames(int count);
[[nodiscard]] MapContent sample_content(int features);
[[nodiscard]] MapSketch sample_sketch(int seed);
[[nodiscard]] SubmapScan sample_submap_scan(std::uint64_t index, int seed);
/// `count` submap scans from `first_index` on.
[[nodiscard]] LocalizerState sample_state(std::uint64_t first_index, int count, int seed);

/// Bit for bit.
[[nodiscard]] bool is_same(const LaserScan& a, const LaserScan& b);
[[nodiscard]] bool is_same(const Pose2& a, const Pose2& b);
[[nodiscard]] bool is_same(const PosedScan& a, const PosedScan& b);
[[nodiscard]] bool is_same(const std::vector<PosedScan>& a, const std::vector<PosedScan>& b);
[[nodiscard]] bool is_same(const std::vector<Feature>& a, const std::vector<Feature>& b);
[[nodiscard]] bool is_same(const DescriptorSet& a, const DescriptorSet& b);
[[nodiscard]] bool is_same(const OccupancyGrid& a, const OccupancyGrid& b);
[[nodiscard]] bool is_same(const MapContent& a, const MapContent& b);
[[nodiscard]] bool is_same(const SubmapScan& a, const SubmapScan& b);
[[nodiscard]] bool is_same(const LocalizerState& a, const LocalizerState& b);
[[nodiscard]] bool is_same(const SessionRecord& a, const SessionRecord& b);

}  // namespace cornerfix::storage
