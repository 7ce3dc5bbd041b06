#include <cornerfix/place_search.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "thinned.hpp"

namespace cornerfix {
namespace {

constexpr double kCell = 0.2;    // wanted cell size [m]
constexpr int kBorder = 160;     // cells that points may reach beyond the map proper
constexpr int kRotations = 180;  // headings looked at: 2 deg apart
constexpr std::size_t kMaxWayPoints = 8;
// Weights are quantised so coarsely that a group of them can be summed in a byte.
constexpr std::size_t kGroup = 8;
static_assert(kMaxWayPoints <= kGroup);
constexpr double kLowestWeight = -1.25;  // [nat], quantised as 0
constexpr double kStepsPerNat =
    18.5;  // the best weight, 0.41, is 31: kGroup times that is under 256
constexpr int kHighestValue = 31;
constexpr int kTopLevel = 2;
constexpr int kTopBlock = 1 << kTopLevel;
constexpr std::size_t kStrip = 32;  // top blocks of a row that are judged together, or not at all
static_assert(kStrip * kTopBlock <= kBorder,
              "a strip that reaches over the map ends in its border");
constexpr std::size_t kCoarsePoints = 40;  // by which the top blocks are judged
constexpr double kCoarseSlack = 0.03;      // and by how much they may misjudge all points [nat]
constexpr std::uint8_t kWayFree = 18;
constexpr std::uint8_t kWayUnknown = 12;
constexpr std::uint8_t kWayBlocked = 0;

std::uint8_t quantised(double weight) {
  return static_cast<std::uint8_t>(
      std::clamp(std::lround((weight - kLowestWeight) * kStepsPerNat), 0L, long{kHighestValue}));
}

std::array<std::uint8_t, 256> end_values() {
  std::array<std::uint8_t, 256> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = (i & 15U) < kFieldClasses
                    ? quantised(static_cast<double>(kSearchWeights.ends[i & 15U]))
                    : 0;
  }
  return values;
}

std::array<std::uint8_t, 256> way_values() {
  std::array<std::uint8_t, 256> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto pass = static_cast<PassClass>(i >> 4U);
    values[i] = pass == PassClass::kUnknown  ? kWayUnknown
                : pass == PassClass::kOnWall ? kWayBlocked
                                             : kWayFree;
  }
  return values;
}

Point2 mean(std::span<const Point2> points) {
  Point2 sum = Point2::Zero();
  for (const Point2& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

struct CellOffset {
  std::int32_t x = 0;
  std::int32_t y = 0;
};

}  // namespace

/// A block of poses: cells [x, x + 2^level) by [y, y + 2^level) of the padded field, one heading.
struct PlaceSearch::Node {
  std::int32_t bound = 0;  ///< No pose in the block scores more.
  std::int16_t x = 0;
  std::int16_t y = 0;
  std::uint8_t rotation = 0;
  std::uint8_t level = 0;
};

/// Blocks still to be looked at, those with the highest bound first and the latest of equals first.
/// Bounds are small whole numbers, so a list a bound is a queue.
class PlaceSearch::Frontier {
 public:
  explicit Frontier(int max_bound) : by_bound_(static_cast<std::size_t>(max_bound) + 1) {}

  void push(const Node& node) {
    by_bound_[static_cast<std::size_t>(node.bound)].push_back(node);
    top_ = std::max(top_, node.bound);
  }
  /// The highest bound of all, or -1.
  [[nodiscard]] int top() {
    while (top_ >= 0 && by_bound_[static_cast<std::size_t>(top_)].empty()) --top_;
    return top_;
  }
  /// Not when it is empty.
  Node pop() {
    std::vector<Node>& nodes = by_bound_[static_cast<std::size_t>(top())];
    const Node node = nodes.back();
    nodes.pop_back();
    return node;
  }

 private:
  std::vector<std::vector<Node>> by_bound_;
  std::int32_t top_ = -1;
};

/// What is looked for, about the centre of the ends.
struct PlaceSearch::Points {
  Point2 center_base_link = Point2::Zero();
  std::vector<Point2> ends;
  std::vector<Point2> way;

  /// From a mean weight of the ends, with all of the way free, to a sum of quantised weights.
  [[nodiscard]] double sum_of(double mean_weight) const {
    return (mean_weight - kLowestWeight) * kStepsPerNat * static_cast<double>(ends.size()) +
           static_cast<double>(kWayFree) * static_cast<double>(way.size());
  }
  [[nodiscard]] double mean_of(int sum) const {
    const double of_ends = sum - static_cast<double>(kWayFree) * static_cast<double>(way.size());
    return of_ends / (kStepsPerNat * static_cast<double>(ends.size())) + kLowestWeight;
  }
};

/// The points in cells from their centre, by heading.
struct PlaceSearch::Query {
  std::size_t end_count = 0;
  std::size_t way_count = 0;
  std::vector<CellOffset> end_offsets;  ///< kRotations rows of end_count.
  std::vector<CellOffset> way_offsets;
  std::vector<std::int32_t> end_indices;  ///< The same as distances in the fields.
  std::vector<std::int32_t> way_indices;
  std::vector<CellOffset> robot_offsets;  ///< Of base_link, which must be in known-free space.
  [[nodiscard]] std::span<const CellOffset> ends(std::size_t rotation) const {
    return std::span(end_offsets).subspan(rotation * end_count, end_count);
  }
  [[nodiscard]] std::span<const std::int32_t> end_index(std::size_t rotation) const {
    return std::span(end_indices).subspan(rotation * end_count, end_count);
  }
  [[nodiscard]] std::span<const std::int32_t> way_index(std::size_t rotation) const {
    return std::span(way_indices).subspan(rotation * way_count, way_count);
  }
};

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi / kRotations;

/// sums[i] += the values of a group of points at i; the inner sum fits a byte, so the compiler
/// takes 16 at a time.
void add_group(std::span<const std::uint8_t*, kGroup> sources, std::size_t shift,
               std::span<std::uint16_t, kStrip> sums) {
  static_assert(kGroup == 8);
  const std::uint8_t* a = sources[0] + shift;
  const std::uint8_t* b = sources[1] + shift;
  const std::uint8_t* c = sources[2] + shift;
  const std::uint8_t* d = sources[3] + shift;
  const std::uint8_t* e = sources[4] + shift;
  const std::uint8_t* f = sources[5] + shift;
  const std::uint8_t* g = sources[6] + shift;
  const std::uint8_t* h = sources[7] + shift;
  std::array<std::uint8_t, kStrip> of_group;
  for (std::size_t i = 0; i < kStrip; ++i) {
    of_group[i] = static_cast<std::uint8_t>(a[i] + b[i] + c[i] + d[i] + e[i] + f[i] + g[i] + h[i]);
  }
  for (std::size_t i = 0; i < kStrip; ++i)
    sums[i] = static_cast<std::uint16_t>(sums[i] + of_group[i]);
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

/// Sums of four blocks side by side, in the 16-bit lanes of two words.
class FourSums {
 public:
  /// Adds the four bytes of each of up to kGroup packed values; their sums fit a byte.
  void add(const std::uint32_t* values, std::span<const std::int32_t> indices) {
    std::uint32_t bytes = 0;
    for (const std::int32_t index : indices) bytes += values[index];
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
  std::uint32_t even_ = 0;  // blocks 0 and 2
  std::uint32_t odd_ = 0;   // blocks 1 and 3
};

}  // namespace

PlaceSearch::PlaceSearch(const ClassField& classes) : T_map_grid_(inverse(classes.T_grid_map())) {
  const int fine_per_cell =
      std::max(1, static_cast<int>(std::lround(kCell / classes.resolution())));
  cell_m_ = fine_per_cell * classes.resolution();
  inner_width_ = (classes.width() + fine_per_cell - 1) / fine_per_cell;
  inner_height_ = (classes.height() + fine_per_cell - 1) / fine_per_cell;
  const auto rounded_up = [](int cells) { return (cells + kTopBlock - 1) / kTopBlock * kTopBlock; };
  width_ = rounded_up(inner_width_) + 2 * kBorder + kTopBlock;
  height_ = rounded_up(inner_height_) + 2 * kBorder + kTopBlock;
  ends_ = make_pyramid(pooled(classes, end_values()), end_values()[ClassField::kOutside]);
  ends_by_phase_ = by_phase(ends_);
  way_ = make_pyramid(pooled(classes, way_values()), way_values()[ClassField::kOutside]);
  way_by_phase_ = by_phase(way_);
}

std::size_t PlaceSearch::bytes() const {
  std::size_t sum = ends_by_phase_.size() + way_by_phase_.size();
  for (const Pyramid* pyramid : {&ends_, &way_}) {
    for (const auto& blocks : pyramid->blocks_below) sum += blocks.size() * sizeof(blocks[0]);
  }
  return sum;
}

std::vector<std::uint8_t> PlaceSearch::pooled(
    const ClassField& classes, std::span<const std::uint8_t, 256> value_of_class) const {
  const int fine_per_cell = static_cast<int>(std::lround(cell_m_ / classes.resolution()));
  // Points and poses are rounded to cells: half a cell either way, and no less.
  const int margin = (fine_per_cell + 1) / 2;
  const auto at = [](int column, int row, int width) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  };
  std::vector<std::uint8_t> by_row(at(0, classes.height(), inner_width_));
  for (int row = 0; row < classes.height(); ++row) {
    for (int column = 0; column < inner_width_; ++column) {
      std::uint8_t best = 0;
      const int end = std::min(classes.width(), (column + 1) * fine_per_cell + margin);
      for (int c = std::max(0, column * fine_per_cell - margin); c < end; ++c) {
        best = std::max(best, value_of_class[classes.packed(c, row)]);
      }
      by_row[at(column, row, inner_width_)] = best;
    }
  }
  std::vector<std::uint8_t> field(at(0, height_, width_), value_of_class[ClassField::kOutside]);
  for (int row = 0; row < inner_height_; ++row) {
    std::uint8_t* target = &field[at(kBorder, row + kBorder, width_)];
    std::fill_n(target, inner_width_, std::uint8_t{0});
    const int end = std::min(classes.height(), (row + 1) * fine_per_cell + margin);
    for (int r = std::max(0, row * fine_per_cell - margin); r < end; ++r) {
      const std::uint8_t* source = &by_row[at(0, r, inner_width_)];
      for (int column = 0; column < inner_width_; ++column)
        target[column] = std::max(target[column], source[column]);
    }
  }
  return field;
}

PlaceSearch::Pyramid PlaceSearch::make_pyramid(std::vector<std::uint8_t> finest,
                                               std::uint8_t outside) const {
  Pyramid pyramid;
  const auto width = static_cast<std::size_t>(width_);
  const auto height = static_cast<std::size_t>(height_);
  std::vector<std::uint8_t> below = std::move(finest);
  for (int level = 1; level <= kTopLevel; ++level) {
    const std::size_t half = std::size_t{1} << (level - 1);
    std::vector<std::uint32_t> blocks(below.size());
    std::vector<std::uint8_t> here(below.size());
    const auto at = [&](std::size_t x, std::size_t y) {
      return x < width && y < height ? below[y * width + x] : outside;
    };
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        const std::array<std::uint8_t, 4> four{at(x, y), at(x + half, y), at(x, y + half),
                                               at(x + half, y + half)};
        blocks[y * width + x] = four[0] | std::uint32_t{four[1]} << 8U |
                                std::uint32_t{four[2]} << 16U | std::uint32_t{four[3]} << 24U;
        here[y * width + x] = *std::max_element(four.begin(), four.end());
      }
    }
    pyramid.blocks_below[static_cast<std::size_t>(level - 1)] = std::move(blocks);
    below = std::move(here);
  }
  return pyramid;
}

std::vector<std::uint8_t> PlaceSearch::by_phase(const Pyramid& pyramid) const {
  constexpr std::size_t kBlock = kTopBlock;
  const auto width = static_cast<std::size_t>(width_);
  const std::size_t blocks_x = width / kBlock;
  const std::size_t blocks_y = static_cast<std::size_t>(height_) / kBlock;
  std::vector<std::uint8_t> laid_out(kBlock * kBlock * blocks_x * blocks_y);
  for (std::size_t y = 0; y < blocks_y * kBlock; ++y) {
    for (std::size_t x = 0; x < blocks_x * kBlock; ++x) {
      const std::size_t phase = (y % kBlock) * kBlock + x % kBlock;
      // The first of the four blocks that make the top one at this cell lies at this cell, too.
      laid_out[(phase * blocks_y + y / kBlock) * blocks_x + x / kBlock] =
          static_cast<std::uint8_t>(pyramid.blocks_below[kTopLevel - 1][y * width + x] & 0xFFU);
    }
  }
  return laid_out;
}

std::array<int, 4> PlaceSearch::bounds_below(const Query& query, const Node& node,
                                             int threshold) const {
  const std::ptrdiff_t origin = static_cast<std::ptrdiff_t>(node.y) * width_ + node.x;
  const auto level = static_cast<std::size_t>(node.level - 1);
  const CellOffset at = query.robot_offsets[node.rotation];
  const std::uint32_t robot =
      way_.blocks_below[level][static_cast<std::size_t>(origin + at.y * width_ + at.x)];
  FourSums sums;
  sums.add(way_.blocks_below[level].data() + origin, query.way_index(node.rotation));
  const std::uint32_t* ends = ends_.blocks_below[level].data() + origin;
  std::span<const std::int32_t> rest = query.end_index(node.rotation);
  while (!rest.empty()) {
    const std::size_t count = std::min(kGroup, rest.size());
    sums.add(ends, rest.first(count));
    rest = rest.subspan(count);
    if (sums.max() + kHighestValue * static_cast<int>(rest.size()) < threshold) return {};
  }
  std::array<int, 4> bounds{};
  for (std::size_t child = 0; child < 4; ++child) {
    if (((robot >> (8U * child)) & 0xFFU) == kWayFree)
      bounds[child] = sums[static_cast<int>(child)];
  }
  return bounds;
}

PlaceSearch::Points PlaceSearch::gather(std::span<const Point2> ends_base_link,
                                        std::span<const Point2> way_base_link,
                                        int max_points) const {
  Points points{.ends = thinned(ends_base_link, static_cast<std::size_t>(max_points)),
                .way = thinned(way_base_link, kMaxWayPoints)};
  if (points.ends.empty()) return points;
  points.center_base_link = mean(points.ends);
  const double reach = (kBorder - 2) * cell_m_;
  for (std::vector<Point2>* part : {&points.ends, &points.way}) {
    for (Point2& p : *part) p -= points.center_base_link;
    std::erase_if(*part, [reach](const Point2& p) { return p.norm() > reach; });
  }
  return points;
}

PlaceSearch::Query PlaceSearch::make_query(const Points& points) const {
  Query query;
  query.end_count = points.ends.size();
  query.way_count = points.way.size();
  for (int rotation = 0; rotation < kRotations; ++rotation) {
    append_offsets(query.end_offsets, points.ends, rotation * kTurn, cell_m_);
    append_offsets(query.way_offsets, points.way, rotation * kTurn, cell_m_);
    append_offsets(query.robot_offsets, std::array{Point2{-points.center_base_link}},
                   rotation * kTurn, cell_m_);
  }
  const auto index_of = [this](const CellOffset& offset) { return offset.y * width_ + offset.x; };
  std::ranges::transform(query.end_offsets, std::back_inserter(query.end_indices), index_of);
  std::ranges::transform(query.way_offsets, std::back_inserter(query.way_indices), index_of);
  return query;
}

double PlaceSearch::mean_weight(std::span<const Point2> ends_base_link,
                                std::span<const Point2> way_base_link, int max_points,
                                const Pose2& T_map_base_link) const {
  const Points points = gather(ends_base_link, way_base_link, max_points);
  const Pose2 T_grid_base_link = inverse(T_map_grid_) * T_map_base_link;
  const Point2 center = (T_grid_base_link * points.center_base_link) / cell_m_;
  const int column = static_cast<int>(std::floor(center.x()));
  const int row = static_cast<int>(std::floor(center.y()));
  if (points.ends.empty() || column < 0 || row < 0 || column >= inner_width_ ||
      row >= inner_height_)
    return kLowestWeight;
  const auto sum = [&](const Pyramid& pyramid, std::span<const Point2> part) {
    std::vector<CellOffset> offsets;
    append_offsets(offsets, part, std::round(T_grid_base_link.yaw / kTurn) * kTurn, cell_m_);
    int total = 0;
    for (const CellOffset& offset : offsets) {
      const std::ptrdiff_t x = column + kBorder + offset.x;
      const std::ptrdiff_t y = row + kBorder + offset.y;
      total += static_cast<int>(
          pyramid.blocks_below.front()[static_cast<std::size_t>(y * width_ + x)] & 0xFFU);
    }
    return total;
  };
  return points.mean_of(sum(ends_, points.ends) + sum(way_, points.way));
}

double PlaceSearch::sum_of_weights(std::span<const Point2> ends_base_link,
                                   const Pose2& T_map_base_link) const {
  const Pose2 T_grid_base_link = inverse(T_map_grid_) * T_map_base_link;
  const double c = std::cos(T_grid_base_link.yaw) / cell_m_;
  const double s = std::sin(T_grid_base_link.yaw) / cell_m_;
  const Point2 origin = T_grid_base_link.translation() / cell_m_;
  int sum = 0;
  for (const Point2& p : ends_base_link) {
    const auto column = static_cast<int>(std::floor(origin.x() + c * p.x() - s * p.y()));
    const auto row = static_cast<int>(std::floor(origin.y() + s * p.x() + c * p.y()));
    if (column < -kBorder || row < -kBorder || column + kBorder >= width_ ||
        row + kBorder >= height_)
      continue;
    const std::ptrdiff_t at =
        std::ptrdiff_t{row + kBorder} * width_ + std::ptrdiff_t{column + kBorder};
    sum += static_cast<int>(ends_.blocks_below.front()[static_cast<std::size_t>(at)] & 0xFFU);
  }
  return sum / kStepsPerNat + kLowestWeight * static_cast<double>(ends_base_link.size());
}

/// What a run has looked at.
struct PlaceSearch::Run::State {
  State(const PlaceSearch& the_search, std::span<const Point2> ends_base_link,
        std::span<const Point2> way_base_link, const PlaceSearchParams& the_params)
      : search(the_search),
        params(the_params),
        points(search.gather(ends_base_link, way_base_link, params.max_points)),
        query(search.make_query(points)),
        open(kHighestValue * static_cast<int>(query.end_count + query.way_count + kGroup)),
        blocks_x(static_cast<std::size_t>((search.inner_width_ + kTopBlock - 1) / kTopBlock)),
        blocks_y(static_cast<std::size_t>((search.inner_height_ + kTopBlock - 1) / kTopBlock)) {
    if (points.ends.empty() || blocks_x == 0 || blocks_y == 0) return;
    judge_top_blocks();
  }

  /// For each top block the best of its four parts, by some of the points.
  void judge_top_blocks();
  /// Opens the top blocks that may reach `bound` and were not opened yet, row by row: blocks side
  /// by side share what they look up.
  void open_down_to(int bound, int threshold);
  void expand(const Node& node, int threshold);
  [[nodiscard]] bool is_known(const Node& node) const;
  [[nodiscard]] std::optional<Place> next(double min_mean_weight);

  /// Of base_link in `grid`, when the centre of the ends is at cells x, y of the padded field.
  [[nodiscard]] Pose2 pose_of(double x, double y, int rotation) const {
    const Pose2 T_grid_center{(x - kBorder) * search.cell_m_, (y - kBorder) * search.cell_m_,
                              wrap_angle(rotation * kTurn)};
    return T_grid_center * Pose2{-points.center_base_link.x(), -points.center_base_link.y(), 0.0};
  }
  /// What a sum over the coarse points says of the sum over all points, at most.
  [[nodiscard]] int bound_of(int coarse_sum) const {
    if (coarse_sum <= 0) return -1;
    const double whole = static_cast<double>(coarse_sum) * static_cast<double>(query.end_count) /
                         static_cast<double>(coarse_count);
    const double slack = coarse_count == query.end_count
                             ? 0.0
                             : kCoarseSlack * kStepsPerNat * static_cast<double>(query.end_count);
    const int way = kWayFree * static_cast<int>(query.way_count);
    return std::min(kHighestValue * static_cast<int>(query.end_count),
                    static_cast<int>(whole + slack)) +
           way;
  }

  const PlaceSearch& search;
  PlaceSearchParams params;
  Points points;
  Query query;
  Frontier open;
  std::size_t blocks_x;
  std::size_t blocks_y;
  std::size_t coarse_count = 0;
  std::vector<std::uint16_t> coarse_sums;  ///< By heading, row and column of top blocks.
  std::vector<std::uint16_t> best_of_row;  ///< By heading and row.
  int closed_below = 0;                    ///< Coarse sums from here on are open.
  std::vector<Pose2> found;                ///< In `grid`.
  std::size_t expansions = 0;
};

void PlaceSearch::Run::State::judge_top_blocks() {
  constexpr auto kBlock = static_cast<std::size_t>(kTopBlock);
  const std::size_t stride = static_cast<std::size_t>(search.width_) / kBlock;
  const std::size_t rows = static_cast<std::size_t>(search.height_) / kBlock;
  coarse_count = std::min(kCoarsePoints, query.end_count);
  coarse_sums.assign(kRotations * blocks_y * blocks_x, 0);
  best_of_row.assign(kRotations * blocks_y, 0);
  const std::vector<std::uint8_t> nothing(stride * rows, 0);
  const auto blocks_from = [&](const std::vector<std::uint8_t>& laid_out, const CellOffset& offset,
                               int part) {
    const auto x = static_cast<std::size_t>(kBorder + offset.x + (part % 2) * kTopBlock / 2);
    const auto y = static_cast<std::size_t>(kBorder + offset.y + (part / 2) * kTopBlock / 2);
    const std::size_t phase = (y % kBlock) * kBlock + x % kBlock;
    return &laid_out[(phase * rows + y / kBlock) * stride + x / kBlock];
  };
  std::vector<const std::uint8_t*> sources;
  std::array<std::uint16_t, kStrip> sums{};
  for (std::size_t rotation = 0; rotation < kRotations; ++rotation) {
    const std::span<const CellOffset> ends = query.ends(rotation);
    for (int part = 0; part < 4; ++part) {
      sources.clear();
      for (std::size_t i = 0; i < coarse_count; ++i) {
        const CellOffset& offset = ends[i * query.end_count / coarse_count];
        sources.push_back(blocks_from(search.ends_by_phase_, offset, part));
      }
      while (sources.size() % kGroup != 0) sources.push_back(nothing.data());
      const std::uint8_t* robot =
          blocks_from(search.way_by_phase_, query.robot_offsets[rotation], part);
      for (std::size_t row = 0; row < blocks_y; ++row) {
        const std::uint8_t* standing = robot + row * stride;
        const std::size_t at = rotation * blocks_y + row;
        std::uint16_t* best = &coarse_sums[at * blocks_x];
        for (std::size_t first = 0; first < blocks_x; first += kStrip) {
          const std::size_t end = std::min(blocks_x, first + kStrip);
          if (std::find(standing + first, standing + end, kWayFree) == standing + end) continue;
          sums.fill(0);
          for (std::size_t group = 0; group < sources.size(); group += kGroup) {
            add_group(std::span<const std::uint8_t*, kGroup>(&sources[group], kGroup),
                      row * stride + first, sums);
          }
          for (std::size_t column = first; column < end; ++column) {
            if (standing[column] == kWayFree)
              best[column] = std::max(best[column], sums[column - first]);
          }
        }
        best_of_row[at] = std::max(best_of_row[at], *std::max_element(best, best + blocks_x));
      }
    }
  }
  closed_below = *std::max_element(best_of_row.begin(), best_of_row.end()) + 1;
}

void PlaceSearch::Run::State::open_down_to(int bound, int threshold) {
  int sum = closed_below;
  while (sum > 0 && bound_of(sum - 1) >= bound) --sum;
  for (std::size_t at = 0; at < best_of_row.size(); ++at) {
    if (best_of_row[at] < sum) continue;
    for (std::size_t column = 0; column < blocks_x; ++column) {
      const int here = coarse_sums[at * blocks_x + column];
      if (here < sum || here >= closed_below) continue;
      ++expansions;
      expand({bound_of(here),
              static_cast<std::int16_t>(kBorder + static_cast<int>(column) * kTopBlock),
              static_cast<std::int16_t>(kBorder + static_cast<int>(at % blocks_y) * kTopBlock),
              static_cast<std::uint8_t>(at / blocks_y), std::uint8_t{kTopLevel}},
             threshold);
    }
  }
  closed_below = sum;
}

bool PlaceSearch::Run::State::is_known(const Node& node) const {
  const double half = 0.5 * (1 << node.level);
  const Pose2 middle = pose_of(node.x + half, node.y + half, node.rotation);
  const double slack = std::numbers::sqrt2 * (half - 0.5) * search.cell_m_;
  return std::any_of(found.begin(), found.end(), [&](const Pose2& place) {
    return distance(place, middle) + slack < params.distinct_distance_m &&
           angle_between(place, middle) < params.distinct_angle_rad;
  });
}

void PlaceSearch::Run::State::expand(const Node& node, int threshold) {
  const int half = 1 << (node.level - 1);
  const std::array<int, 4> bounds = search.bounds_below(query, node, threshold);
  for (int child = 0; child < 4; ++child) {
    Node next = node;
    next.level = static_cast<std::uint8_t>(node.level - 1);
    next.x = static_cast<std::int16_t>(node.x + (child % 2) * half);
    next.y = static_cast<std::int16_t>(node.y + (child / 2) * half);
    if (next.x >= kBorder + search.inner_width_ || next.y >= kBorder + search.inner_height_)
      continue;
    next.bound = bounds[static_cast<std::size_t>(child)];
    if (next.bound >= threshold) open.push(next);
  }
}

std::optional<Place> PlaceSearch::Run::State::next(double min_mean_weight) {
  if (coarse_sums.empty()) return std::nullopt;
  const int threshold = std::max(0, static_cast<int>(points.sum_of(min_mean_weight)));
  const int step =
      std::max(1, static_cast<int>(0.05 * kStepsPerNat * static_cast<double>(query.end_count)));
  while (expansions < params.max_expansions) {
    const int closed = bound_of(closed_below - 1);  // no block that is not open yet reaches more
    if (closed >= threshold && closed > open.top()) {
      open_down_to(std::max({threshold, open.top(), closed - step}), threshold);
      continue;
    }
    if (open.top() < threshold) return std::nullopt;
    const Node node = open.pop();
    ++expansions;
    if (is_known(node)) continue;
    if (node.level > 0) {
      expand(node, threshold);
      continue;
    }
    found.push_back(pose_of(node.x + 0.5, node.y + 0.5, node.rotation));
    return Place{search.T_map_grid_ * found.back(), points.mean_of(node.bound)};
  }
  return std::nullopt;
}

PlaceSearch::Run::Run(const PlaceSearch& search, std::span<const Point2> ends_base_link,
                      std::span<const Point2> way_base_link, const PlaceSearchParams& params)
    : state_(std::make_unique<State>(search, ends_base_link, way_base_link, params)) {}
PlaceSearch::Run::~Run() = default;
PlaceSearch::Run::Run(Run&&) noexcept = default;

std::optional<Place> PlaceSearch::Run::next(double min_mean_weight) {
  return state_->next(min_mean_weight);
}

std::vector<Place> PlaceSearch::find(std::span<const Point2> ends_base_link,
                                     std::span<const Point2> way_base_link,
                                     const PlaceSearchParams& params) const {
  Run run(*this, ends_base_link, way_base_link, params);
  std::vector<Place> places;
  double least = params.min_mean_weight;
  while (places.size() < params.max_places) {
    const std::optional<Place> place = run.next(least);
    if (!place) break;
    places.push_back(*place);
    least = std::max(least, places.front().mean_weight - params.max_mean_gap);
  }
  return places;
}

}  // namespace cornerfix
