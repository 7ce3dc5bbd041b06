/// \file  Where one frame was in another one at any recent time.
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>

namespace cornerfix {

struct FoundTransform {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  bool is_final = true;  ///< No transform that is still to come can change it.
};

/// Keeps the last seconds. Not synchronised.
class TransformTrack {
 public:
  /// An older transform than the last one is passed over. When it is older by more than 2 s, or
  /// younger by more than 20 s, the clock was set, and a new run begins. Scans of the run before
  /// may still be waiting.
  void add(double stamp, const Eigen::Isometry3d& T);

  /// Interpolated between stamps at most a second apart, or further if the frame did not move in
  /// between; beyond the last one it holds for a tenth of a second. Nothing when there is no such
  /// stamp.
  [[nodiscard]] std::optional<FoundTransform> at(double stamp) const;

  [[nodiscard]] bool has_moved() const { return has_moved_; }

  [[nodiscard]] std::optional<double> last_stamp() const {
    return samples_.empty() ? std::nullopt : std::optional(samples_.back().stamp);
  }

 private:
  struct Sample {
    double stamp;
    Eigen::Isometry3d transform;
  };

  using Samples = std::deque<Sample>;  ///< By stamp.

  [[nodiscard]] static std::optional<FoundTransform> at(const Samples& samples, double stamp);

  Samples samples_;
  Samples run_before_;
  bool has_moved_ = false;
};

}  // namespace cornerfix
