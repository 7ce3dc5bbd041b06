/// \file  How much of a map's extent its keyframes can have seen.
#pragma once

#include <optional>

#include <cornerfix/mapper.hpp>
#include <cornerfix/result.hpp>

namespace cornerfix::server {

/// Two poses kilometres apart, one of them wrong say, make a grid of unknown cells that costs
/// seconds and gigabytes. So a map may span no more than a few times what its keyframes saw.
class SeenArea {
 public:
  SeenArea() = default;
  /// Of all keyframes of `mapper`.
  SeenArea(const Mapper& mapper, const MapperParams& params);

  void add(const PosedScan& key_frame, const MapperParams& params);

  /// Why the map may not have these bounds, or nothing. kInvalidArgument, without a field.
  [[nodiscard]] std::optional<Error> reject(const std::optional<Bounds>& bounds,
                                            const MapperParams& params) const;

 private:
  double area_m2_ = 0.0;  ///< Sum of the boxes around what each keyframe saw.
};

}  // namespace cornerfix::server
