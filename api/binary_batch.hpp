/// \file  A batch of a session as application/octet-stream: float32 ranges behind a header.
///
/// Little endian, without padding. docs/http-api.md has an example.
///
/// | byte | type | |
/// |---|---|---|
/// | 0 | 4 bytes | "CFS1" |
/// | 4 | uint32 | flags: 1 when each scan has odometry, else 0 |
/// | 8 | uint64 | sequence |
/// | 16 | uint32 | scans |
/// | 20 | uint32 | ranges per scan |
///
/// Then each scan: stamp (float64), with odometry x, y and yaw (float64), ranges (float32).
#pragma once

#include <string_view>

#include "api/document_builder.hpp"

namespace cornerfix::api {

/// Gives `builder` the events of the same batch in JSON. So limits, values and pointers of errors
/// are the same. False when it cannot be read: builder.problem() has the byte, and what was
/// expected there.
[[nodiscard]] bool read_binary_batch(std::string_view body, DocumentBuilder& builder);

}  // namespace cornerfix::api
