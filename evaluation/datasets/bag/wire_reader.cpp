#include "evaluation/datasets/bag/wire_reader.hpp"

namespace cornerfix::evaluation {

WireReader::WireReader(std::span<const std::byte> bytes, WireFormat format) : bytes_(bytes) {
  static_assert(std::endian::native == std::endian::little);
  if (format == WireFormat::kRos1) return;
  const std::span<const std::byte> header = this->bytes(4);
  if (header.empty()) return;
  // Plain CDR of version 1, big- or little-endian: what ROS 2 writes.
  const auto representation =
      (std::to_integer<int>(header[0]) << 8) | std::to_integer<int>(header[1]);
  ok_ = representation == 0 || representation == 1;
  is_swapped_ = representation == 0;
  is_aligned_ = true;
  origin_ = at_;
}

void WireReader::align(std::size_t size) {
  if (!is_aligned_) return;
  const std::size_t over = (at_ - origin_) % size;
  if (over != 0) bytes(size - over);
}

std::span<const std::byte> WireReader::bytes(std::size_t size) {
  if (size > rest()) ok_ = false;
  if (!ok_) return {};
  const auto taken = bytes_.subspan(at_, size);
  at_ += size;
  return taken;
}

std::string_view WireReader::text() {
  const std::size_t size = count(1);
  const std::span<const std::byte> taken = bytes(size);
  // A view of bytes as the characters that they are.
  std::string_view text(reinterpret_cast<const char*>(taken.data()), taken.size());  // NOLINT
  if (is_aligned_ && text.ends_with('\0')) text.remove_suffix(1);
  return text;
}

std::size_t WireReader::count(std::size_t element_bytes) {
  const auto count = number<std::uint32_t>();
  if (count > rest() / element_bytes) ok_ = false;
  return ok_ ? count : 0;
}

}  // namespace cornerfix::evaluation
