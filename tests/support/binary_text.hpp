/// \file  Bodies of application/octet-stream, written value by value.
#pragma once

#include <cstdint>
#include <string>

namespace cornerfix::api {

/// The values' bytes, one after the other.
template <typename... Values>
[[nodiscard]] std::string binary_text(const Values&... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
  return bytes;
}

struct BinaryHeader {
  std::uint32_t flags = 0;
  std::uint64_t sequence = 0;
  std::uint32_t scans = 0;
  std::uint32_t beams = 0;
};

[[nodiscard]] inline std::string binary_header(const BinaryHeader& header) {
  return "CFS1" + binary_text(header.flags, header.sequence, header.scans, header.beams);
}

}  // namespace cornerfix::api
