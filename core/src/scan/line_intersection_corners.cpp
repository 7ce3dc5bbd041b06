#include "core/src/scan/line_intersection_corners.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/src/base/cross.hpp"

namespace cornerfix {
namespace {

using Index = std::ptrdiff_t;  // of a return; signed, because arms reach to both sides

constexpr double kMinNoise = 0.006;  // [m]
// Neighbours farther apart than this lie on different surfaces.
constexpr double kGapBase = 0.10;      // [m]
constexpr double kSinGrazing = 0.139;  // sin(8 deg): a wall seen flatter is cut into its returns
constexpr double kGapSigmas = 6.0;
constexpr double kArmSigmas = 8.0;     // shortest arms: noise must not look like a turn
constexpr double kProminence = 4.0;    // a peak of the gain is so many times higher than a valley
constexpr double kOnLineSigmas = 3.0;  // a return this near to an arm's line lies on it
constexpr double kSurelyOnLine = 1.0;  // sigmas; the last return of an arm is this near
constexpr int kMaxRounds = 4;          // of growing and splitting again
// A round pillar saves by splitting its arms again, a corner of walls does not: no more than this
// share of its gain, or than noise does.
constexpr double kMaxBend = 0.015;
constexpr double kMaxBendOfNoise = 12.0;  // [sigma^2]
constexpr double kMinSine = 0.1;          // of the angle between two lines that fix a point
constexpr double kPriorResiduals = 4.0;  // an arm's own count for more than the scan's noise beyond
constexpr double kSameCorner = 0.2;      // corners nearer than this are one [m]

double squared_distance(const Point2& a, const Point2& b) { return (a - b).squaredNorm(); }

/// A line through a run of returns.
struct Line {
  Point2 centroid = Point2::Zero();
  Point2 direction = Point2::UnitX();  // unit, away from the corner
  double count = 0.0;
  double squared_residuals = 0.0;
  double spread = 0.0;  // sum of squared distances from the centroid along the line

  [[nodiscard]] double distance_to(const Point2& p) const {
    return std::abs(cross(direction, p - centroid));
  }
};

/// The returns from `near`, next to the corner, to `far`, both included.
struct Arm {
  Index near = 0;
  Index far = 0;
};

/// Returns in beam order, with prefix sums that make a line through any run of them cost the same.
class Returns {
 public:
  /// A full turn has no first beam: behind its last return the first ones come again, as far as
  /// `reach` from the seam.
  Returns(const LaserScan& scan, double reach) {
    const std::size_t beams = scan.ranges.size();
    points_.reserve(beams + beams / 2);
    // One rotation a beam instead of a sine and a cosine.
    const Point2 turn(std::cos(scan.angle_increment), std::sin(scan.angle_increment));
    Point2 heading(std::cos(scan.angle_min), std::sin(scan.angle_min));
    for (std::size_t beam = 0; beam < beams; ++beam) {
      if (scan.has_return(beam))
        points_.emplace_back(static_cast<double>(scan.ranges[beam]) * heading);
      heading = {heading.x() * turn.x() - heading.y() * turn.y(),
                 heading.x() * turn.y() + heading.y() * turn.x()};
    }
    distinct_ = points_.size();
    const double step = std::abs(scan.angle_increment);
    if (static_cast<double>(beams) * step > 2.0 * std::numbers::pi - 1.5 * step)
      repeat_first(reach);
    add_up();
  }

  [[nodiscard]] Index size() const { return static_cast<Index>(points_.size()); }
  /// Without the repeated ones.
  [[nodiscard]] Index distinct() const { return static_cast<Index>(distinct_); }
  [[nodiscard]] const Point2& operator[](Index i) const {
    return points_[static_cast<std::size_t>(i)];
  }

  /// Of the best line through the returns [begin, end).
  [[nodiscard]] double squared_residuals(Index begin, Index end) const {
    return scatter(begin, end).least();
  }

  [[nodiscard]] Line fit(const Arm& arm) const {
    const Scatter s = scatter(std::min(arm.near, arm.far), std::max(arm.near, arm.far) + 1);
    Line line{s.mean, s.axis(), s.count, s.least(), 0.0};
    line.spread = s.xx + s.yy - line.squared_residuals;
    if (line.direction.dot((*this)[arm.far] - (*this)[arm.near]) < 0.0)
      line.direction = -line.direction;
    return line;
  }

 private:
  struct Sums {
    double x = 0.0;
    double y = 0.0;
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
  };

  /// Second moments about the mean.
  struct Scatter {
    Point2 mean;
    double count;
    double xx;
    double xy;
    double yy;

    [[nodiscard]] double root() const { return std::sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy); }
    /// The smaller eigenvalue.
    [[nodiscard]] double least() const { return std::max(0.0, 0.5 * (xx + yy - root())); }
    /// The eigenvector of the greater one.
    [[nodiscard]] Point2 axis() const {
      const Point2 v =
          xx > yy ? Point2(xx - yy + root(), 2.0 * xy) : Point2(2.0 * xy, yy - xx + root());
      return v.isZero(0.0) ? Point2::UnitX() : Point2(v.normalized());
    }
  };

  void repeat_first(double reach) {
    for (std::size_t i = 0; i < distinct_ / 2; ++i) {
      if (squared_distance(points_[i], points_[0]) > reach * reach) break;
      points_.push_back(points_[i]);
    }
  }

  void add_up() {
    sums_.resize(points_.size() + 1);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Point2& p = points_[i];
      const Sums& s = sums_[i];
      sums_[i + 1] = {s.x + p.x(), s.y + p.y(), s.xx + p.x() * p.x(), s.xy + p.x() * p.y(),
                      s.yy + p.y() * p.y()};
    }
  }

  [[nodiscard]] Scatter scatter(Index begin, Index end) const {
    const Sums& a = sums_[static_cast<std::size_t>(begin)];
    const Sums& b = sums_[static_cast<std::size_t>(end)];
    const double n = static_cast<double>(end - begin);
    const double x = (b.x - a.x) / n;
    const double y = (b.y - a.y) / n;
    return {{x, y}, n, b.xx - a.xx - n * x * x, b.xy - a.xy - n * x * y, b.yy - a.yy - n * y * y};
  }

  std::vector<Point2> points_;
  std::size_t distinct_ = 0;
  std::vector<Sums> sums_;
};

class CornerFinder {
 public:
  CornerFinder(const LaserScan& scan, const LineIntersectionParams& params)
      : params_(params),
        returns_(scan, 2.0 * params.max_arm_length_m),
        min_points_(params.min_arm_points),
        step_(std::abs(scan.angle_increment)),
        sense_(scan.angle_increment < 0.0 ? -1.0 : 1.0),
        sigma_(std::max(estimate_range_noise(scan), params.min_noise_m)) {}

  std::vector<Corner> find() {
    Index begin = 0;
    for (Index i = 1; i <= returns_.size(); ++i) {
      if (i < returns_.size() && is_next_on_surface(i)) continue;
      find_on_surface(begin, i);
      begin = i;
    }
    return std::move(corners_);
  }

 private:
  /// Returns [begin, split) and [split, end). The corner lies between two beams: one shared by both
  /// sides would bend a line.
  struct Window {
    Index begin;
    Index split;
    Index end;
  };

  [[nodiscard]] bool is_next_on_surface(Index i) const {
    const double range = returns_[i].norm();
    const double gap = kGapBase + range * step_ / kSinGrazing + kGapSigmas * sigma_;
    return squared_distance(returns_[i], returns_[i - 1]) <= gap * gap;
  }

  /// Finds the peaks of the gain along the returns [begin, end), each the start of a corner.
  void find_on_surface(Index begin, Index end) {
    const double threshold = params_.min_first_gain * sigma_ * sigma_;
    Window peak{};
    double peak_gain = 0.0;  // 0 while going down from the last peak
    double valley = 0.0;
    for (Window window{begin, begin + min_points_, begin}; window.split + min_points_ <= end;) {
      slide(window, end);
      const double gain = gain_of(window);
      if (gain > std::max({threshold, peak_gain, kProminence * valley})) {
        peak = window;
        peak_gain = gain;
      } else if (peak_gain == 0.0) {
        valley = std::min(valley, gain);
      } else if (gain * kProminence < peak_gain || window.begin >= peak.split) {
        grow_and_keep(peak, begin, end);
        peak_gain = 0.0;
        valley = gain;
      }
      // Long arms change little from beam to beam.
      window.split += std::max<Index>(1, (window.end - window.begin) / 8);
    }
    if (peak_gain > 0.0) grow_and_keep(peak, begin, end);
  }

  /// Moves the ends of the window to an arm's length from its split.
  void slide(Window& window, Index end) const {
    const double length = std::max(params_.arm_length_m, kArmSigmas * sigma_);
    const Point2& middle = returns_[window.split];
    const auto is_far = [&](Index i) {
      return squared_distance(returns_[i], middle) > length * length;
    };
    while (window.begin + min_points_ < window.split && is_far(window.begin)) ++window.begin;
    window.end = std::max(window.end, window.split + min_points_);
    while (window.end < end && !is_far(window.end)) ++window.end;
  }

  /// Squared residuals that two lines save against one.
  [[nodiscard]] double gain_of(const Window& window) const {
    return returns_.squared_residuals(window.begin, window.end) -
           returns_.squared_residuals(window.begin, window.split) -
           returns_.squared_residuals(window.split, window.end);
  }

  /// Grows both arms and splits again where their lines meet, until that changes nothing.
  void grow_and_keep(const Window& window, Index begin, Index end) {
    Index split = window.split;
    Arm left{split - 1, window.begin};
    Arm right{split, window.end - 1};
    for (int round = 0; round < kMaxRounds; ++round) {
      left = {split - 1, std::min(left.far, split - min_points_)};
      right = {split, std::max(right.far, split + min_points_ - 1)};
      const Line left_line = grown(left, begin, -1);
      const Line right_line = grown(right, end - 1, 1);
      const std::optional<Point2> meeting = intersection(left_line, right_line);
      if (!meeting) return;
      const Index before = split;
      split = split_behind(*meeting, left.far, split, right.far);
      if (split - min_points_ < begin || split + min_points_ > end) return;
      if (split != before && round + 1 < kMaxRounds) continue;
      const Line left_end = trimmed(left, left_line, 1);
      const Line right_end = trimmed(right, right_line, -1);
      keep(left, left_end, right, right_end);
      return;
    }
  }

  /// Lengthens an arm towards `last` while returns stay on its line. One stray return alone does
  /// not end it.
  [[nodiscard]] Line grown(Arm& arm, Index last, Index sense) const {
    constexpr Index kMostAtOnce = 1 << 20;  // so that doubling ends before it overflows
    Line line = returns_.fit(arm);
    for (Index most = 1; arm.far != last; most = std::min(2 * most, kMostAtOnce)) {
      const Index before = arm.far;
      for (Index i = 0; i < most && arm.far != last; ++i) {
        const Index next = arm.far + sense;
        if (!belongs(next, line, arm) && (next == last || !belongs(next + sense, line, arm))) break;
        arm.far = next;
      }
      if (arm.far == before) break;
      line = returns_.fit(arm);
    }
    return line;
  }

  [[nodiscard]] bool belongs(Index i, const Line& line, const Arm& arm) const {
    const double length = params_.max_arm_length_m;
    return line.distance_to(returns_[i]) <= kOnLineSigmas * sigma_ &&
           squared_distance(returns_[i], returns_[arm.near]) <= length * length;
  }

  /// Takes an arm back to its last return that is surely on the line: one that ran a little into
  /// the next wall is bent by it.
  [[nodiscard]] Line trimmed(Arm& arm, const Line& line, Index sense) const {
    while (std::abs(arm.far - arm.near) >= min_points_ &&
           line.distance_to(returns_[arm.far]) > kSurelyOnLine * sigma_)
      arm.far += sense;
    return returns_.fit(arm);
  }

  static std::optional<Point2> intersection(const Line& a, const Line& b) {
    const double sine = cross(a.direction, b.direction);
    if (std::abs(sine) < kMinSine) return std::nullopt;
    return a.centroid + cross(b.centroid - a.centroid, b.direction) / sine * a.direction;
  }

  /// The first return whose beam passes behind `corner`.
  [[nodiscard]] Index split_behind(const Point2& corner, Index first, Index split,
                                   Index last) const {
    const auto is_behind = [&](Index i) { return sense_ * cross(corner, returns_[i]) > 0.0; };
    while (split > first && is_behind(split - 1)) --split;
    while (split <= last && !is_behind(split)) ++split;
    return split;
  }

  /// Makes the corner of two finished arms, unless it fails a test.
  void keep(const Arm& left, const Line& left_line, const Arm& right, const Line& right_line) {
    const std::optional<Point2> position = intersection(left_line, right_line);
    if (!position || !lies_between(*position, returns_[left.near], returns_[right.near])) return;
    if (is_grazing(left_line, *position) || is_grazing(right_line, *position)) return;
    Corner corner;
    corner.position = *position;
    corner.turn_angle =
        std::acos(std::clamp(-left_line.direction.dot(right_line.direction), -1.0, 1.0));
    if (corner.turn_angle < params_.min_turn_angle_rad) return;
    const double noise = sigma_ * sigma_;
    corner.gain = gain_of({left.far, right.near, right.far + 1}) / noise;
    if (corner.gain < params_.min_gain) return;
    const double bend = (bend_of(right.near, right.far) + bend_of(left.far, left.near)) / noise;
    if (bend > std::max(kMaxBend * corner.gain, kMaxBendOfNoise)) return;
    const Point2 inward = left_line.direction + right_line.direction;
    corner.bisector = std::atan2(inward.y(), inward.x());
    corner.convex = inward.dot(*position) > 0.0;
    corner.covariance = covariance(left_line, right_line, *position);
    keep_best(corner, right.near >= returns_.distinct());
  }

  /// Whether the corner lies where the returns beside it are, not far along one of the lines.
  [[nodiscard]] bool lies_between(const Point2& corner, const Point2& left,
                                  const Point2& right) const {
    const double reach = std::max(params_.arm_length_m, (right - left).norm());
    return std::max(squared_distance(corner, left), squared_distance(corner, right)) <=
           reach * reach;
  }

  [[nodiscard]] bool is_grazing(const Line& arm, const Point2& corner) const {
    return std::abs(cross(arm.direction, corner.normalized())) <
           std::sin(params_.min_incidence_rad);
  }

  /// What two lines in place of an arm's one would save.
  [[nodiscard]] double bend_of(Index first, Index last) const {
    return gain_of({first, (first + last + 1) / 2, last + 1});
  }

  /// Each line fixes the position across itself, the less surely the farther its returns are.
  [[nodiscard]] Eigen::Matrix2d covariance(const Line& left, const Line& right,
                                           const Point2& corner) const {
    Eigen::Matrix2d normals;
    normals << -left.direction.y(), left.direction.x(), -right.direction.y(), right.direction.x();
    const Eigen::Matrix2d inverse = normals.inverse();
    const Eigen::Vector2d variances(variance_at(corner, left), variance_at(corner, right));
    return inverse * variances.asDiagonal() * inverse.transpose();
  }

  /// Of a line's place across itself. The noise across a wall seen at an angle is less than that of
  /// the ranges. So it is estimated from the arm's own residuals, as far as there are enough of
  /// them.
  [[nodiscard]] double variance_at(const Point2& point, const Line& line) const {
    const double noise = (line.squared_residuals + kPriorResiduals * sigma_ * sigma_) /
                         (line.count - 2.0 + kPriorResiduals);
    const double along = line.direction.dot(point - line.centroid);
    return noise * (1.0 / line.count + along * along / std::max(line.spread, 1e-9));
  }

  /// A corner may be found twice: from two peaks, or on both sides of the seam.
  void keep_best(const Corner& corner, bool beyond_seam) {
    for (Corner& known : corners_) {
      if (squared_distance(known.position, corner.position) > kSameCorner * kSameCorner) continue;
      if (corner.gain > known.gain) known = corner;
      return;
    }
    // Beyond the seam the beams count from the first again.
    corners_.insert(beyond_seam ? corners_.begin() + beyond_seam_++ : corners_.end(), corner);
  }

  const LineIntersectionParams& params_;
  Returns returns_;
  Index min_points_;
  double step_;
  double sense_;
  double sigma_;
  std::vector<Corner> corners_;
  Index beyond_seam_ = 0;
};

}  // namespace

std::optional<Error> validate(const LineIntersectionParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (!(params.arm_length_m > 0.0)) return broken("arm_length_m", "must be above 0 m");
  if (!(params.max_arm_length_m >= params.arm_length_m))
    return broken("max_arm_length_m", "must be at least arm_length_m");
  if (params.min_arm_points < 3) return broken("min_arm_points", "must be at least 3");
  if (!(params.min_first_gain > 0.0)) return broken("min_first_gain", "must be above 0");
  if (!(params.min_gain > 0.0)) return broken("min_gain", "must be above 0");
  if (!(params.min_turn_angle_rad > 0.0 && params.min_turn_angle_rad < std::numbers::pi)) {
    return broken("min_turn_angle_rad", "must be in (0, pi) rad");
  }
  if (!(params.min_incidence_rad >= 0.0 && params.min_incidence_rad < std::numbers::pi / 2.0)) {
    return broken("min_incidence_rad", "must be in [0, pi/2) rad");
  }
  if (!(params.min_noise_m >= 0.0)) return broken("min_noise_m", "must be at least 0 m");
  return std::nullopt;
}

double estimate_range_noise(const LaserScan& scan) {
  std::vector<float> differences;
  differences.reserve(scan.ranges.size() / 2);
  // Neighbouring differences share returns and add little to every other one.
  for (std::size_t i = 1; i + 1 < scan.ranges.size(); i += 2) {
    if (!scan.has_return(i - 1) || !scan.has_return(i) || !scan.has_return(i + 1)) continue;
    differences.push_back(
        std::abs(scan.ranges[i - 1] - 2.0F * scan.ranges[i] + scan.ranges[i + 1]));
  }
  if (differences.empty()) return kMinNoise;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  // The median of |N(0, s)| is 0.6745 s; a second difference has six times the variance of a range.
  return std::max(kMinNoise, static_cast<double>(*middle) / (0.6745 * std::sqrt(6.0)));
}

std::vector<Corner> extract_line_intersection_corners(const LaserScan& scan,
                                                      const LineIntersectionParams& params) {
  return CornerFinder(scan, params).find();
}

}  // namespace cornerfix
