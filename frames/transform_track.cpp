#include "frames/transform_track.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace cornerfix {

namespace {

constexpr std::size_t kMaxSamples = 20000;
constexpr double kKeptSeconds = 20.0;
constexpr double kSetBackSeconds = 2.0;
constexpr double kMaxGapSeconds = 1.0;
constexpr double kHeldSeconds = 0.1;
constexpr double kSameTransform = 1e-9;

Eigen::Isometry3d interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                              double share) {
  Eigen::Isometry3d between = Eigen::Isometry3d::Identity();
  between.translation() = a.translation() + share * (b.translation() - a.translation());
  const Eigen::Quaterniond from(a.linear());
  const Eigen::Quaterniond to(b.linear());
  between.linear() = from.slerp(share, to).toRotationMatrix();
  return between;
}

}  // namespace

void TransformTrack::add(double stamp, const Eigen::Isometry3d& T) {
  if (!samples_.empty()) {
    const Sample& last = samples_.back();
    has_moved_ = has_moved_ || !last.transform.isApprox(T, kSameTransform);
    if (stamp < last.stamp - kSetBackSeconds || stamp > last.stamp + kKeptSeconds) {
      run_before_ = std::exchange(samples_, {});
    } else if (stamp <= last.stamp) {
      return;
    }
  }
  samples_.push_back({stamp, T});
  while (samples_.front().stamp < stamp - kKeptSeconds || samples_.size() > kMaxSamples) {
    samples_.pop_front();
  }
}

std::optional<FoundTransform> TransformTrack::at(double stamp) const {
  const auto found = at(samples_, stamp);
  return found ? found : at(run_before_, stamp);
}

std::optional<FoundTransform> TransformTrack::at(const Samples& samples, double stamp) {
  if (samples.empty()) return std::nullopt;
  const auto after =
      std::lower_bound(samples.begin(), samples.end(), stamp,
                       [](const Sample& sample, double time) { return sample.stamp < time; });
  if (after == samples.end()) {
    const Sample& last = samples.back();
    if (stamp - last.stamp > kHeldSeconds) return std::nullopt;
    return FoundTransform{last.transform, false};
  }
  if (after->stamp == stamp) return FoundTransform{after->transform, true};
  if (after == samples.begin()) return std::nullopt;
  const Sample& before = *std::prev(after);
  const double gap = after->stamp - before.stamp;
  const bool is_at_rest = before.transform.isApprox(after->transform, kSameTransform);
  if (gap > kMaxGapSeconds && !is_at_rest) return std::nullopt;
  return FoundTransform{
      interpolate(before.transform, after->transform, (stamp - before.stamp) / gap), true};
}

}  // namespace cornerfix
