/// \file  Straightens the scans of a batch that were taken beam by beam.
#pragma once

#include <vector>

#include "api/scan_batch.hpp"

namespace cornerfix::api {

/// By the motion to the next scan of the same laser, or else from the one before: of `odom`, or
/// else of `pose`. A scan whose motion is not known stays as it is.
void straighten(std::vector<BatchScan>& scans);

}  // namespace cornerfix::api
