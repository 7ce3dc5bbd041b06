#include "core/src/search/place_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "core/src/base/thinned.hpp"
#include "core/src/search/frontier.hpp"
#include "core/src/search/place_fields.hpp"
#include "core/src/search/strip_sums.hpp"
#include "core/src/search/work_budget.hpp"

namespace cornerfix {
namespace {

constexpr int kRotations = 180;  // headings looked at: 2 deg apart
constexpr double kHeadingStep = 2.0 * std::numbers::pi / kRotations;
constexpr std::size_t kMaxWayPoints = 8;
// Strips are scored by a few of the points, by more, and by all. The mean over some differs from
// that over all by less than a slack. This holds for 19 blocks of 20 whose bound is the threshold,
// and for all that are far above it.
struct Sample {
  std::size_t points;
  double slack;  // [nat]
};
constexpr std::array kSamples{Sample{2 * kGroup, 0.12}, Sample{5 * kGroup, 0.05}};
constexpr std::size_t kEnoughBlocks = 8192;  // to open at a time
// Few points give many blocks the same bound. More than this exceed `max_expansions` by far.
constexpr std::size_t kMostBlocks = 500'000;
// Headings are taken in an order whose every beginning is spread over the circle. So the first ones
// give an estimate of the cut-off for the blocks to open.
constexpr std::size_t kHeadingStride = 67;
constexpr std::size_t kHeadStart = 20;  // headings that the first may be taken for
static_assert(std::gcd(kHeadingStride, std::size_t{kRotations}) == 1);
static_assert(kHighestValue * kGroup < 256 && kWayFree <= kHighestValue, "a group fits a byte");
static_assert(kStrip * kBlock <= kBorder, "a strip that reaches over the map ends in its border");

Point2 mean(std::span<const Point2> points) {
  Point2 sum = Point2::Zero();
  for (const Point2& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// The same points in an order whose every beginning is evenly spread over all (multiples of the
/// golden ratio fill an interval so).
std::vector<Point2> spread(std::span<const Point2> points) {
  const auto when = [](std::size_t i) {
    const double turns = static_cast<double>(i) / std::numbers::phi;
    return turns - std::floor(turns);
  };
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, when);
  std::vector<Point2> in_order;
  in_order.reserve(points.size());
  for (const std::size_t i : order) in_order.push_back(points[i]);
  return in_order;
}

void append_offsets(std::vector<CellOffset>& offsets, std::span<const Point2> points, double yaw,
                    double cell_m) {
  const double c = std::cos(yaw) / cell_m;
  const double s = std::sin(yaw) / cell_m;
  for (const Point2& p : points) {
    offsets.push_back({static_cast<std::int32_t>(std::lround(c * p.x() - s * p.y())),
                       static_cast<std::int32_t>(std::lround(s * p.x() + c * p.y()))});
  }
}

/// What is looked for, about the centre of the ends.
struct Points {
  Points(std::span<const Point2> ends_base_link, std::span<const Point2> way_base_link,
         int max_points, double cell_m)
      : ends(spread(thinned(ends_base_link, static_cast<std::size_t>(max_points)))),
        way(thinned(way_base_link, kMaxWayPoints)) {
    if (ends.empty()) return;
    center_base_link = mean(ends);
    const double reach = (kBorder - 2) * cell_m;
    if (center_base_link.norm() > reach) ends.clear();  // the robot would be off the field
    for (std::vector<Point2>* part : {&ends, &way}) {
      for (Point2& p : *part) p -= center_base_link;
      std::erase_if(*part, [reach](const Point2& p) { return p.norm() > reach; });
    }
  }

  /// From a mean weight of the ends, with all of the way free, to a sum of quantised weights.
  [[nodiscard]] double sum_of(double mean_weight) const {
    return (mean_weight - kLowestWeight) * kStepsPerNat * static_cast<double>(ends.size()) +
           static_cast<double>(highest_of_way());
  }
  [[nodiscard]] double mean_of(int sum) const {
    return (sum - highest_of_way()) / (kStepsPerNat * static_cast<double>(ends.size())) +
           kLowestWeight;
  }
  [[nodiscard]] int highest_of_way() const { return kWayFree * static_cast<int>(way.size()); }
  [[nodiscard]] int highest() const {
    return kHighestValue * static_cast<int>(ends.size()) + highest_of_way();
  }

  Point2 center_base_link = Point2::Zero();
  std::vector<Point2> ends;
  std::vector<Point2> way;
};

/// The points at one heading, in cells from their centre.
struct Turned {
  std::vector<CellOffset> ends;
  std::vector<CellOffset> way;
  CellOffset robot;  ///< base_link, which must be in known-free space.

  static Turned of(const Points& points, double yaw, double cell_m) {
    Turned turned;
    append_offsets(turned.ends, points.ends, yaw, cell_m);
    append_offsets(turned.way, points.way, yaw, cell_m);
    std::vector<CellOffset> robot;
    append_offsets(robot, std::array{Point2{-points.center_base_link}}, yaw, cell_m);
    turned.robot = robot.front();
    return turned;
  }
};

/// Columns of blocks, from `first` to before `end`.
struct ColumnRange {
  std::size_t first = 0;
  std::size_t end = 0;
};

/// The blocks of one heading that touch a disc; `disc` is in units of blocks, and the middle of
/// block i is at i.
ColumnRange columns_within(const Disc& disc, std::size_t row, std::size_t columns) {
  const double reach = disc.radius_m + std::numbers::sqrt2 / 2.0;
  const double across = static_cast<double>(row) - disc.center.y();
  if (std::abs(across) > reach) return {};
  const double half = std::sqrt(reach * reach - across * across);
  const auto column = [&](double at) {
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(columns)));
  };
  return {column(std::ceil(disc.center.x() - half)),
          column(std::floor(disc.center.x() + half) + 1.0)};
}

/// Sums of the four cells of a block, in the 16-bit lanes of two words.
class FourSums {
 public:
  /// Adds the four bytes of the words at up to kGroup offsets; their sums fit a byte.
  void add(const std::uint32_t* quads, std::ptrdiff_t width, std::span<const CellOffset> offsets) {
    std::uint32_t bytes = 0;
    for (const CellOffset& offset : offsets) bytes += quads[offset.y * width + offset.x];
    even_ += bytes & 0x00FF00FFU;
    odd_ += (bytes >> 8U) & 0x00FF00FFU;
  }
  [[nodiscard]] int operator[](int i) const {
    const std::uint32_t word = i % 2 == 0 ? even_ : odd_;
    return static_cast<int>((word >> (i < 2 ? 0U : 16U)) & 0xFFFFU);
  }
  [[nodiscard]] int max() const {
    return std::max(std::max((*this)[0], (*this)[1]), std::max((*this)[2], (*this)[3]));
  }

 private:
  std::uint32_t even_ = 0;  // cells 0 and 2
  std::uint32_t odd_ = 0;   // cells 1 and 3
};

}  // namespace

/// What a run has looked at.
struct PlaceSearch::Run::State {
  /// Blocks with bounds in [least, below), of the headings before the `next_heading`-th.
  struct Opening {
    int least = 0;
    int below = 0;
    std::size_t next_heading = 0;
    std::size_t count = 0;  ///< Of blocks with bounds of at least `least`.
    std::vector<std::size_t> count_by_bound;
    std::vector<Node> blocks;
  };

  State(const PlaceFields& the_fields, std::span<const Point2> ends_base_link,
        std::span<const Point2> way_base_link, PlaceSearchParams the_params)
      : fields(the_fields),
        params(std::move(the_params)),
        points(ends_base_link, way_base_link, params.max_points, fields.cell_m),
        open(points.highest()),
        opened_down_to(points.highest() + 1) {
    for (int rotation = 0; rotation < kRotations && !points.ends.empty(); ++rotation)
      turned.push_back(Turned::of(points, rotation * kHeadingStep, fields.cell_m));
  }

  /// The best place that was not given yet.
  [[nodiscard]] std::optional<Node> next(int threshold, WorkBudget& budget);
  /// Opens more blocks that may reach the threshold, of very many the best. Continues an opening
  /// that the budget interrupted.
  void open_blocks(int threshold, WorkBudget& budget);
  void open_heading(Opening& begun, WorkBudget& budget) const;
  /// The blocks of one heading whose bounds are in [least, below).
  void collect_blocks(int rotation, int least, int below, std::vector<Node>& blocks,
                      WorkBudget& budget) const;
  void expand(Node block, int threshold, WorkBudget& budget);
  [[nodiscard]] bool is_known(const Node& node) const;
  [[nodiscard]] bool may_have_heading(int rotation) const;
  /// Where the region leaves room for the centres of blocks at one heading, in units of blocks;
  /// endless without a region.
  [[nodiscard]] Disc region_in_blocks(int rotation) const;
  [[nodiscard]] bool is_in_region(const Node& node) const;

  /// What a sample of the ends must sum up to where all points are to reach the threshold.
  [[nodiscard]] int sampled_least(const Sample& sample, int threshold) const {
    const auto all = static_cast<double>(points.ends.size());
    const double of_all = threshold - points.highest_of_way() - sample.slack * kStepsPerNat * all;
    return static_cast<int>(std::ceil(of_all * static_cast<double>(sample.points) / all));
  }
  /// Of base_link in `grid`, when the centre of the ends is in the middle of a node.
  [[nodiscard]] Pose2 pose_of(const Node& node) const {
    const double half = node.is_block ? 0.5 * kBlock : 0.5;
    const Pose2 T_grid_center{(node.x + half - kBorder) * fields.cell_m,
                              (node.y + half - kBorder) * fields.cell_m,
                              wrap_angle(node.rotation * kHeadingStep)};
    return T_grid_center * Pose2{-points.center_base_link.x(), -points.center_base_link.y(), 0.0};
  }

  const PlaceFields& fields;
  PlaceSearchParams params;
  Points points;
  std::vector<Turned> turned;  ///< By heading.
  Frontier open;
  int opened_down_to;              ///< No block with this bound or more is still to be opened.
  std::optional<Opening> opening;  ///< Interrupted.
  std::vector<Pose2> found;        ///< In `grid`.
  std::size_t expansions = 0;
};

std::optional<Node> PlaceSearch::Run::State::next(int threshold, WorkBudget& budget) {
  while (expansions < params.max_expansions) {
    if (open.top() < opened_down_to && threshold < opened_down_to) {
      open_blocks(threshold, budget);
    } else {
      if (open.top() < threshold) return std::nullopt;
      const Node node = open.pop();
      ++expansions;
      budget.charge(1 + found.size());
      if (!is_known(node)) {
        if (!node.is_block) return node;
        expand(node, threshold, budget);
      }
    }
    if (budget.is_spent()) return std::nullopt;
  }
  return std::nullopt;
}

void PlaceSearch::Run::State::open_blocks(int threshold, WorkBudget& budget) {
  if (!opening) {
    opening = Opening();
    opening->least = threshold;
    opening->below = opened_down_to;
    opening->count_by_bound.resize(static_cast<std::size_t>(opened_down_to));
  }
  while (opening->next_heading < turned.size() && opening->least < opening->below) {
    open_heading(*opening, budget);
    ++opening->next_heading;
    if (budget.is_spent()) return;
  }
  if (opening->least == opened_down_to) expansions = params.max_expansions;  // too many at once
  opened_down_to = opening->least;
  for (const Node& block : opening->blocks) {
    if (block.bound >= opened_down_to) open.push(block);
  }
  opening.reset();
}

void PlaceSearch::Run::State::open_heading(Opening& begun, WorkBudget& budget) const {
  const std::size_t before = begun.blocks.size();
  collect_blocks(static_cast<int>(begun.next_heading * kHeadingStride % kRotations), begun.least,
                 begun.below, begun.blocks, budget);
  for (const Node& block : std::span(begun.blocks).subspan(before))
    ++begun.count_by_bound[static_cast<std::size_t>(block.bound)];
  begun.count += begun.blocks.size() - before;
  budget.charge(2 * (begun.blocks.size() - before));
  const std::size_t enough = kEnoughBlocks * (begun.next_heading + kHeadStart) / kRotations;
  const auto drop_lowest = [&] {
    begun.count -= begun.count_by_bound[static_cast<std::size_t>(begun.least++)];
  };
  while (begun.count - begun.count_by_bound[static_cast<std::size_t>(begun.least)] >= enough)
    drop_lowest();
  while (begun.count > kMostBlocks) drop_lowest();
  if (begun.blocks.size() > 2 * kMostBlocks)
    std::erase_if(begun.blocks, [&](const Node& block) { return block.bound < begun.least; });
}

void PlaceSearch::Run::State::collect_blocks(int rotation, int least, int below,
                                             std::vector<Node>& blocks, WorkBudget& budget) const {
  const std::size_t stride = fields.ends.blocks_a_row();
  const auto blocks_x = static_cast<std::size_t>((fields.inner_width + kBlock - 1) / kBlock);
  const auto blocks_y = static_cast<std::size_t>((fields.inner_height + kBlock - 1) / kBlock);
  if (!may_have_heading(rotation)) return;
  const Disc disc = region_in_blocks(rotation);
  const auto from = [](const BlockField& field, const CellOffset& offset) {
    return field.maxima_from(kBorder + offset.x, kBorder + offset.y);
  };
  const Turned& here = turned[static_cast<std::size_t>(rotation)];
  std::vector<const std::uint8_t*> sources;
  for (const CellOffset& end : here.ends) sources.push_back(from(fields.ends, end));
  for (const CellOffset& passed : here.way) sources.push_back(from(fields.way, passed));
  while (sources.size() % kGroup != 0) sources.push_back(fields.nothing.data());
  const std::uint8_t* robot = from(fields.way, here.robot);

  const std::span<const std::uint8_t* const> all = sources;
  std::vector<SumStep> steps;
  std::size_t taken = 0;
  for (const Sample& sample : kSamples) {
    if (sample.points >= here.ends.size()) break;
    steps.push_back({all.subspan(taken, sample.points - taken), sampled_least(sample, least)});
    taken = sample.points;
  }
  steps.push_back({all.subspan(taken), least});
  StripSums sums;
  std::size_t groups = 0;
  for (std::size_t row = 0; row < blocks_y; ++row) {
    const ColumnRange columns = columns_within(disc, row, blocks_x);
    for (std::size_t column = columns.first; column < columns.end; column += kStrip) {
      const std::size_t at = row * stride + column;
      const std::size_t count = std::min(kStrip, columns.end - column);
      if (std::memchr(robot + at, kWayFree, count) == nullptr) continue;
      if (!sum_strip(steps, robot, kWayFree, at, sums, groups)) continue;
      for (std::size_t i = 0; i < count; ++i) {
        if (robot[at + i] == kWayFree && sums[i] >= least && sums[i] < below)
          blocks.push_back({sums[i], kBorder + static_cast<int>(column + i) * kBlock,
                            kBorder + static_cast<int>(row) * kBlock,
                            static_cast<std::uint8_t>(rotation), true});
      }
    }
  }
  budget.charge(groups + blocks_y * (blocks_x / kStrip + 1));
}

/// A block that turns out not to reach the threshold waits with what is known of it.
void PlaceSearch::Run::State::expand(Node block, int threshold, WorkBudget& budget) {
  const Turned& here = turned[block.rotation];
  const std::ptrdiff_t width = fields.width;
  const std::ptrdiff_t origin = block.y * width + block.x;
  FourSums sums;
  sums.add(fields.way.quads() + origin, width, here.way);
  std::span<const CellOffset> rest = here.ends;
  while (!rest.empty()) {
    const std::size_t count = std::min(kGroup, rest.size());
    sums.add(fields.ends.quads() + origin, width, rest.first(count));
    budget.charge(1);
    rest = rest.subspan(count);
    block.bound = std::min(block.bound, sums.max() + kHighestValue * static_cast<int>(rest.size()));
    if (block.bound < threshold) return open.push(block);
  }
  for (int cell = 0; cell < 4; ++cell) {
    const Node one{sums[cell], block.x + cell % 2, block.y + cell / 2, block.rotation, false};
    if (one.x < kBorder + fields.inner_width && one.y < kBorder + fields.inner_height &&
        fields.way.cell(one.x + here.robot.x, one.y + here.robot.y) == kWayFree &&
        is_in_region(one))
      open.push(one);
  }
}

bool PlaceSearch::Run::State::may_have_heading(int rotation) const {
  const double yaw = rotation * kHeadingStep + fields.T_map_grid.yaw;
  return !params.region || params.region->has_heading(yaw, 0.5 * kHeadingStep);
}

Disc PlaceSearch::Run::State::region_in_blocks(int rotation) const {
  if (!params.region) return {Point2::Zero(), std::numeric_limits<double>::infinity()};
  const double yaw = rotation * kHeadingStep;
  const Disc base_link =
      params.region->positions_at(yaw + fields.T_map_grid.yaw, 0.5 * kHeadingStep);
  const Point2 center = inverse(fields.T_map_grid) * base_link.center +
                        Pose2{0.0, 0.0, yaw} * points.center_base_link;
  const double block_m = kBlock * fields.cell_m;
  return {center / block_m - Point2(0.5, 0.5), base_link.radius_m / block_m};
}

bool PlaceSearch::Run::State::is_in_region(const Node& node) const {
  return !params.region ||
         params.region->contains(fields.T_map_grid * pose_of(node),
                                 std::numbers::sqrt2 / 2.0 * fields.cell_m, 0.5 * kHeadingStep);
}

bool PlaceSearch::Run::State::is_known(const Node& node) const {
  const Pose2 middle = pose_of(node);
  const double slack =
      node.is_block ? std::numbers::sqrt2 * 0.5 * (kBlock - 1) * fields.cell_m : 0.0;
  return std::any_of(found.begin(), found.end(), [&](const Pose2& place) {
    return distance(place, middle) + slack < params.distinct_distance_m &&
           angle_between(place, middle) < params.distinct_angle_rad;
  });
}

PlaceSearch::Run::Run(const PlaceSearch& search, std::span<const Point2> ends_base_link,
                      std::span<const Point2> way_base_link, const PlaceSearchParams& params)
    : state_(std::make_unique<State>(*search.fields_, ends_base_link, way_base_link, params)) {}
PlaceSearch::Run::~Run() = default;
PlaceSearch::Run::Run(Run&&) noexcept = default;

std::optional<Place> PlaceSearch::Run::next(double min_mean_weight, WorkBudget& budget) {
  const std::optional<Node> node =
      state_->next(std::max(0, static_cast<int>(state_->points.sum_of(min_mean_weight))), budget);
  if (!node) return std::nullopt;
  state_->found.push_back(state_->pose_of(*node));
  return Place{state_->fields.T_map_grid * state_->found.back(),
               state_->points.mean_of(node->bound)};
}

double PlaceSearch::Run::bound() const {
  if (state_->points.ends.empty()) return kHighestValue / kStepsPerNat + kLowestWeight;
  return state_->points.mean_of(std::max(state_->open.top(), state_->opened_down_to - 1));
}

PlaceSearch::PlaceSearch(const ClassField& classes)
    : fields_(std::make_unique<const PlaceFields>(classes)) {}
PlaceSearch::~PlaceSearch() = default;
PlaceSearch::PlaceSearch(PlaceSearch&&) noexcept = default;

std::size_t PlaceSearch::bytes() const {
  return fields_->ends.bytes() + fields_->way.bytes() + fields_->nothing.size();
}

std::vector<Place> PlaceSearch::find(std::span<const Point2> ends_base_link,
                                     std::span<const Point2> way_base_link,
                                     const PlaceSearchParams& params) const {
  Run run(*this, ends_base_link, way_base_link, params);
  WorkBudget unbounded;
  std::vector<Place> places;
  double least = params.min_mean_weight;
  while (places.size() < params.max_places) {
    const std::optional<Place> place = run.next(least, unbounded);
    if (!place) break;
    places.push_back(*place);
    least = std::max(least, places.front().mean_weight - params.max_mean_gap);
  }
  return places;
}

double PlaceSearch::mean_weight(std::span<const Point2> ends_base_link,
                                std::span<const Point2> way_base_link, int max_points,
                                const Pose2& T_map_base_link) const {
  const Points points(ends_base_link, way_base_link, max_points, fields_->cell_m);
  const Pose2 T_grid_base_link = inverse(fields_->T_map_grid) * T_map_base_link;
  const Point2 center = (T_grid_base_link * points.center_base_link) / fields_->cell_m;
  const auto column = static_cast<int>(std::floor(center.x()));
  const auto row = static_cast<int>(std::floor(center.y()));
  if (points.ends.empty() || column < 0 || row < 0 || column >= fields_->inner_width ||
      row >= fields_->inner_height)
    return kLowestWeight;
  const Turned here = Turned::of(
      points, std::round(T_grid_base_link.yaw / kHeadingStep) * kHeadingStep, fields_->cell_m);
  int sum = 0;
  const auto add = [&](const BlockField& field, std::span<const CellOffset> offsets) {
    for (const CellOffset& offset : offsets)
      sum += field.cell(column + kBorder + offset.x, row + kBorder + offset.y);
  };
  add(fields_->ends, here.ends);
  add(fields_->way, here.way);
  return points.mean_of(sum);
}

double PlaceSearch::sum_of_weights(std::span<const Point2> ends_base_link,
                                   const Pose2& T_map_base_link) const {
  const Pose2 T_grid_base_link = inverse(fields_->T_map_grid) * T_map_base_link;
  const double c = std::cos(T_grid_base_link.yaw) / fields_->cell_m;
  const double s = std::sin(T_grid_base_link.yaw) / fields_->cell_m;
  const Point2 origin = T_grid_base_link.translation() / fields_->cell_m;
  int sum = 0;
  for (const Point2& p : ends_base_link) {
    const auto column = static_cast<int>(std::floor(origin.x() + c * p.x() - s * p.y())) + kBorder;
    const auto row = static_cast<int>(std::floor(origin.y() + s * p.x() + c * p.y())) + kBorder;
    if (column >= 0 && row >= 0 && column < fields_->width && row < fields_->height)
      sum += fields_->ends.cell(column, row);
  }
  return sum / kStepsPerNat + kLowestWeight * static_cast<double>(ends_base_link.size());
}

}  // namespace cornerfix
