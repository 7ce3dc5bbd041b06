/// \file  The fields of a BLOB, written and read one after the other. Private to the codec.
#pragma once

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <concepts>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "storage/blob_codec.hpp"

namespace cornerfix::storage {

inline constexpr std::size_t kHeaderSize = 2;  // Version, kind.
inline constexpr std::size_t kChecksumSize = 4;

// The values are stored: never renumber them.
enum class BlobKind : std::uint8_t {
  kKeyFrame = 1,
  kFeatures = 2,
  kDescriptors = 3,
  kGrid = 4,
  kSubmapScan = 5,
  kLocalizerState = 6,
  kMapSketch = 7,
};

/// The version that is written. All before it can be read.
constexpr std::uint8_t newest_version(BlobKind kind) {
  if (kind == BlobKind::kLocalizerState) return 5;
  return kind == BlobKind::kFeatures ? 2 : 1;
}

template <std::unsigned_integral T>
void store_little_endian(std::uint8_t* to, T value) {
  auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  std::memcpy(to, bytes.data(), sizeof(T));
}

template <std::unsigned_integral T>
T load_little_endian(const std::uint8_t* from) {
  std::array<std::uint8_t, sizeof(T)> bytes;
  std::memcpy(bytes.data(), from, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

inline std::uint32_t crc_32(BlobView bytes) {
  return static_cast<std::uint32_t>(::crc32_z(0, bytes.data(), bytes.size()));
}

/// Appends fields to a BLOB of one kind.
class BlobWriter {
 public:
  BlobWriter(BlobKind kind, std::size_t payload_size) {
    bytes_.reserve(kHeaderSize + payload_size + kChecksumSize);
    integer(newest_version(kind));
    integer(static_cast<std::uint8_t>(kind));
  }

  template <std::unsigned_integral T>
  void integer(T value) {
    store_little_endian(extend(sizeof(T)), value);
  }
  void signed_integer(int value) { integer(static_cast<std::uint32_t>(value)); }
  void real(double value) { integer(std::bit_cast<std::uint64_t>(value)); }
  void single(float value) { integer(std::bit_cast<std::uint32_t>(value)); }
  void count(std::size_t value) {
    assert(value <= std::numeric_limits<std::uint32_t>::max() && "too many items for a BLOB");
    integer(static_cast<std::uint32_t>(value));
  }
  void pose(const Pose2& pose) {
    for (const double value : {pose.x, pose.y, pose.yaw}) real(value);
  }
  void scan(const LaserScan& scan) {
    for (const double value :
         {scan.stamp, scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max}) {
      real(value);
    }
    count(scan.ranges.size());
    std::uint8_t* to = extend(scan.ranges.size() * sizeof(float));
    for (const float range : scan.ranges) {
      store_little_endian(to, std::bit_cast<std::uint32_t>(range));
      to += sizeof(float);
    }
  }
  /// Room for `size` bytes, for the caller to fill.
  std::uint8_t* extend(std::size_t size) {
    bytes_.resize(bytes_.size() + size);
    return bytes_.data() + bytes_.size() - size;
  }
  Blob finish() && {
    integer(crc_32(bytes_));
    return std::move(bytes_);
  }

 private:
  Blob bytes_;
};

/// Takes fields from a BLOB. Once one is missing all later ones are zero and finished() is false,
/// so that decoding needs one test at its end.
class BlobReader {
 public:
  explicit BlobReader(BlobView payload) : rest_(payload) {}

  template <std::unsigned_integral T>
  T integer() {
    const BlobView field = bytes(sizeof(T));
    return field.empty() ? T{0} : load_little_endian<T>(field.data());
  }
  int signed_integer() { return static_cast<int>(integer<std::uint32_t>()); }
  double real() { return std::bit_cast<double>(integer<std::uint64_t>()); }
  float single() { return std::bit_cast<float>(integer<std::uint32_t>()); }
  /// A number of items that follow; zero when fewer bytes than that are left.
  std::size_t count(std::size_t item_size) {
    const std::size_t value = integer<std::uint32_t>();
    if (value <= rest_.size() / item_size) return value;
    complete_ = false;
    return 0;
  }
  Pose2 pose() {
    const double x = real();
    const double y = real();
    const double yaw = real();
    return {x, y, yaw};
  }
  LaserScan scan() {
    LaserScan scan;
    for (double* field :
         {&scan.stamp, &scan.angle_min, &scan.angle_increment, &scan.range_min, &scan.range_max}) {
      *field = real();
    }
    scan.ranges.resize(count(sizeof(float)));
    const BlobView ranges = bytes(scan.ranges.size() * sizeof(float));
    for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      scan.ranges[beam] = std::bit_cast<float>(
          load_little_endian<std::uint32_t>(ranges.data() + beam * sizeof(float)));
    }
    return scan;
  }
  BlobView bytes(std::size_t size) {
    if (!complete_ || size > rest_.size()) {
      complete_ = false;
      return {};
    }
    const BlobView taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  BlobView rest() { return bytes(rest_.size()); }
  [[nodiscard]] bool finished() const { return complete_ && rest_.empty(); }

 private:
  BlobView rest_;
  bool complete_ = true;
};

[[nodiscard]] Error corrupt(std::string_view what, std::string_view why);
[[nodiscard]] Error inconsistent(std::string_view what);

/// The payload of `blob` if its version, kind and checksum are right.
[[nodiscard]] Result<BlobReader> open_blob(BlobKind kind, std::string_view what, BlobView blob);

}  // namespace cornerfix::storage
