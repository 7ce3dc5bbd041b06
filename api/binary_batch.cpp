#include "api/binary_batch.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace cornerfix::api {
namespace {

constexpr std::string_view kMagic = "CFS1";
constexpr std::size_t kHeaderBytes = 24;
constexpr std::uint32_t kHasOdometry = 1;
constexpr std::uint64_t kOdometryBytes = 3 * sizeof(double);

class BinaryBatchReader {
 public:
  BinaryBatchReader(std::string_view body, DocumentBuilder& builder)
      : rest_(body), builder_(builder) {}

  bool read() {
    if (!read_header() || !builder_.start_object(2)) return false;
    if (!key("sequence") || !builder_.number_unsigned(sequence_)) return false;
    if (!key("scans") || !builder_.start_array(scans_)) return false;
    for (std::uint64_t i = 0; i < scans_; ++i) {
      if (!read_scan()) return false;
    }
    return builder_.end_array() && builder_.end_object();
  }

 private:
  bool read_header() {
    const std::size_t size = rest_.size();
    if (!rest_.starts_with(kMagic)) return fail("Byte 0: expected the letters CFS1.");
    if (size < kHeaderBytes) {
      return fail("The body ends after " + std::to_string(size) + " bytes, in its header of " +
                  std::to_string(kHeaderBytes) + ".");
    }
    rest_.remove_prefix(kMagic.size());
    const auto flags = take<std::uint32_t>();
    if (flags > kHasOdometry) {
      return fail("Byte 4: flags " + std::to_string(flags) +
                  ", expected 0, or 1 for scans with odometry.");
    }
    odometry_bytes_ = flags == kHasOdometry ? kOdometryBytes : 0;
    sequence_ = take<std::uint64_t>();
    scans_ = take<std::uint32_t>();
    beams_ = take<std::uint32_t>();
    return check_size(size);
  }

  bool check_size(std::size_t size) {
    const std::uint64_t scan = sizeof(double) + odometry_bytes_ + beams_ * sizeof(float);
    // Divided, since the product of two numbers that a body claims may overflow.
    if (rest_.size() / scan == scans_ && rest_.size() % scan == 0) return true;
    return fail("The body has " + std::to_string(size) + " bytes, expected a header of " +
                std::to_string(kHeaderBytes) + " and, by its bytes 4, 16 and 20, " +
                std::to_string(scans_) + " scans of " + std::to_string(scan) +
                ": 8 of the stamp, " + std::to_string(odometry_bytes_) + " of odometry, " +
                std::to_string(beams_) + " ranges of 4.");
  }

  bool read_scan() {
    if (!builder_.start_object(3) || !read_number("stamp")) return false;
    if (odometry_bytes_ > 0 && !read_pose("odom")) return false;
    if (!key("ranges") || !builder_.start_array(beams_)) return false;
    for (std::uint64_t i = 0; i < beams_; ++i) {
      if (!builder_.range(static_cast<double>(take<float>()))) return false;
    }
    return builder_.end_array() && builder_.end_object();
  }

  bool read_pose(const char* name) {
    return key(name) && builder_.start_object(3) && read_number("x") && read_number("y") &&
           read_number("yaw") && builder_.end_object();
  }

  bool read_number(const char* name) {
    return key(name) && builder_.number_float(take<double>(), {});
  }

  bool key(std::string name) { return builder_.key(name); }

  bool fail(std::string detail) {
    return builder_.fail(make_problem(ErrorCode::kMalformed, std::move(detail)));
  }

  /// Of bytes that are known to be enough.
  template <typename T>
  T take() {
    static_assert(std::endian::native == std::endian::little);
    T value;
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return value;
  }

  std::string_view rest_;
  DocumentBuilder& builder_;
  std::uint64_t odometry_bytes_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t scans_ = 0;
  std::uint64_t beams_ = 0;
};

}  // namespace

bool read_binary_batch(std::string_view body, DocumentBuilder& builder) {
  return BinaryBatchReader(body, builder).read();
}

}  // namespace cornerfix::api
