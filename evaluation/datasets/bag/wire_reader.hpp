/// \file  Numbers and texts one after the other, as ROS 1 and CDR (ROS 2) put them into bytes.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace cornerfix::evaluation {

enum class WireFormat {
  kRos1,  ///< Little-endian and packed; so are the records of both kinds of bags.
  kCdr,   ///< OMG's Common Data Representation: four bytes with the byte order, then aligned.
};

/// Never reads past the end: there it gives zeros and is not ok() from then on, so that a whole
/// message can be read and judged once. The bytes must outlive it and its texts.
class WireReader {
 public:
  explicit WireReader(std::span<const std::byte> bytes, WireFormat format = WireFormat::kRos1);

  template <typename Number>
  Number number() {
    static_assert(std::is_arithmetic_v<Number>);
    align(sizeof(Number));
    const std::span<const std::byte> taken = bytes(sizeof(Number));
    if (taken.empty()) return {};
    std::array<std::byte, sizeof(Number)> raw;
    std::copy(taken.begin(), taken.end(), raw.begin());
    if (is_swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<Number>(raw);
  }

  /// A length and as many characters; without the zero that ends them in CDR.
  std::string_view text();
  /// The length of a sequence whose elements take at least `element_bytes` each; one that the rest
  /// cannot hold is not ok(), so that nothing is allocated for it.
  std::size_t count(std::size_t element_bytes);
  /// The next `size` bytes, or none and not ok().
  std::span<const std::byte> bytes(std::size_t size);

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t rest() const { return bytes_.size() - at_; }

 private:
  void align(std::size_t size);

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::size_t origin_ = 0;  ///< Where alignment counts from.
  bool is_aligned_ = false;
  bool is_swapped_ = false;
  bool ok_ = true;
};

}  // namespace cornerfix::evaluation
