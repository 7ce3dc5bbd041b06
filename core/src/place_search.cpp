#include <cornerfix/place_search.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

namespace cornerfix {
namespace {

constexpr double kCell = 0.2;    // wanted cell size [m]
constexpr int kBorder = 160;     // cells that points may reach beyond the map proper
constexpr int kRotations = 180;  // headings looked at: 2 deg apart
constexpr std::size_t kMaxWayPoints = 8;
// Weights are quantised so coarsely that a group of them can be summed in a byte.
constexpr std::size_t kGroup = 8;
constexpr double kLowestWeight = -1.7;  // [nat], quantised as 0
constexpr double kStepsPerNat =
    12.0;  // the best weight, 0.85, is 31: kGroup times that is under 256
constexpr int kHighestValue = 31;
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
    values[i] = (i & 15U) < kEndClasses ? quantised(static_cast<double>(kEndWeights[i & 15U])) : 0;
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

/// Every k-th of `points`, at most `count`.
std::vector<Point2> thinned(std::span<const Point2> points, std::size_t count) {
  std::vector<Point2> kept;
  const std::size_t n = std::min(points.size(), count);
  kept.reserve(n);
  for (std::size_t i = 0; i < n; ++i) kept.push_back(points[i * points.size() / n]);
  return kept;
}

Point2 mean(std::span<const Point2> points) {
  Point2 sum = Point2::Zero();
  for (const Point2& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

struct CellOffset {
  std::int16_t x = 0;
  std::int16_t y = 0;
};

}  // namespace

/// A block of poses: cells [x, x + 2^level) by [y, y + 2^level) of the padded field, one heading.
struct PlaceSearch::Node {
  std::int32_t bound = 0;  ///< No pose in the block scores more.
  std::int16_t x = 0;
  std::int16_t y = 0;
  std::uint8_t rotation = 0;
  std::uint8_t level = 0;

  /// Heap order: highest bound first, then the finest block; the rest makes the order total.
  friend bool operator<(const Node& a, const Node& b) {
    if (a.bound != b.bound) return a.bound < b.bound;
    if (a.level != b.level) return a.level > b.level;
    if (a.rotation != b.rotation) return a.rotation > b.rotation;
    return a.y != b.y ? a.y > b.y : a.x > b.x;
  }
};

/// The points in cells from their centre, by heading.
struct PlaceSearch::Query {
  Point2 center_base_link = Point2::Zero();
  std::size_t end_count = 0;
  std::size_t way_count = 0;
  std::vector<CellOffset> end_offsets;  ///< kRotations rows of end_count.
  std::vector<CellOffset> way_offsets;
  int threshold = 0;

  [[nodiscard]] std::span<const CellOffset> ends(std::size_t rotation) const {
    return std::span(end_offsets).subspan(rotation * end_count, end_count);
  }
  [[nodiscard]] std::span<const CellOffset> way(std::size_t rotation) const {
    return std::span(way_offsets).subspan(rotation * way_count, way_count);
  }
};

namespace {

/// sums[i] += the values of a group of points at i; the inner sum fits a byte, so the compiler
/// takes 16 at a time.
void add_group(std::span<const std::uint8_t*, kGroup> sources, std::size_t shift,
               std::span<std::uint16_t> sums) {
  static_assert(kGroup == 8);
  const std::uint8_t* a = sources[0] + shift;
  const std::uint8_t* b = sources[1] + shift;
  const std::uint8_t* c = sources[2] + shift;
  const std::uint8_t* d = sources[3] + shift;
  const std::uint8_t* e = sources[4] + shift;
  const std::uint8_t* f = sources[5] + shift;
  const std::uint8_t* g = sources[6] + shift;
  const std::uint8_t* h = sources[7] + shift;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const auto sum =
        static_cast<std::uint8_t>(a[i] + b[i] + c[i] + d[i] + e[i] + f[i] + g[i] + h[i]);
    sums[i] = static_cast<std::uint16_t>(sums[i] + sum);
  }
}

void append_offsets(std::vector<CellOffset>& offsets, std::span<const Point2> points,
                    const Point2& center, double yaw, double cell_m) {
  const double c = std::cos(yaw) / cell_m;
  const double s = std::sin(yaw) / cell_m;
  for (const Point2& point : points) {
    const Point2 p = point - center;
    offsets.push_back({static_cast<std::int16_t>(std::lround(c * p.x() - s * p.y())),
                       static_cast<std::int16_t>(std::lround(s * p.x() + c * p.y()))});
  }
}

}  // namespace

PlaceSearch::PlaceSearch(const ClassField& classes) : T_map_grid_(inverse(classes.T_grid_map())) {
  const int fine_per_cell =
      std::max(1, static_cast<int>(std::lround(kCell / classes.resolution())));
  cell_m_ = fine_per_cell * classes.resolution();
  inner_width_ = (classes.width() + fine_per_cell - 1) / fine_per_cell;
  inner_height_ = (classes.height() + fine_per_cell - 1) / fine_per_cell;
  // Small blocks bound well and are cheap as long as there are few of them.
  constexpr double kManyCells = 400.0 * 400.0;
  top_level_ = static_cast<double>(inner_width_) * inner_height_ > kManyCells ? 3 : 2;
  const int block = 1 << top_level_;
  const auto rounded_up = [block](int cells) { return (cells + block - 1) / block * block; };
  width_ = rounded_up(inner_width_) + 2 * kBorder + block;
  height_ = rounded_up(inner_height_) + 2 * kBorder + block;
  ends_ = make_pyramid(pooled(classes, end_values()), end_values()[ClassField::kOutside]);
  way_ = make_pyramid(pooled(classes, way_values()), way_values()[ClassField::kOutside]);
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
  pyramid.levels.push_back(std::move(finest));
  const auto width = static_cast<std::size_t>(width_);
  const auto height = static_cast<std::size_t>(height_);
  for (int level = 1; level <= top_level_; ++level) {
    const std::vector<std::uint8_t>& below = pyramid.levels.back();
    const std::size_t half = std::size_t{1} << (level - 1);
    std::vector<std::uint8_t> here(below.size());
    const auto at = [&](std::size_t x, std::size_t y) {
      return x < width && y < height ? below[y * width + x] : outside;
    };
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t x = 0; x < width; ++x) {
        here[y * width + x] =
            std::max({at(x, y), at(x + half, y), at(x, y + half), at(x + half, y + half)});
      }
    }
    pyramid.levels.push_back(std::move(here));
  }
  const std::size_t block = std::size_t{1} << top_level_;
  const std::size_t blocks_x = width / block;
  const std::size_t blocks_y = height / block;
  pyramid.top_by_phase.resize(block * block * blocks_x * blocks_y);
  for (std::size_t y = 0; y < blocks_y * block; ++y) {
    for (std::size_t x = 0; x < blocks_x * block; ++x) {
      const std::size_t phase = (y % block) * block + x % block;
      pyramid.top_by_phase[(phase * blocks_y + y / block) * blocks_x + x / block] =
          pyramid.levels.back()[y * width + x];
    }
  }
  return pyramid;
}

int PlaceSearch::bound(const Query& query, const Node& node) const {
  const std::ptrdiff_t origin = static_cast<std::ptrdiff_t>(node.y) * width_ + node.x;
  int total = 0;
  const std::uint8_t* way = way_.levels[node.level].data() + origin;
  for (const CellOffset offset : query.way(node.rotation))
    total += way[offset.y * width_ + offset.x];
  const std::uint8_t* ends = ends_.levels[node.level].data() + origin;
  std::span<const CellOffset> rest = query.ends(node.rotation);
  while (!rest.empty()) {
    const std::size_t count = std::min(kGroup, rest.size());
    for (const CellOffset offset : rest.first(count)) total += ends[offset.y * width_ + offset.x];
    rest = rest.subspan(count);
    if (total + kHighestValue * static_cast<int>(rest.size()) < query.threshold) return 0;
  }
  return total;
}

void PlaceSearch::search_top(const Query& query, std::vector<Node>& open) const {
  const int block = 1 << top_level_;
  const std::size_t blocks_x = static_cast<std::size_t>(width_ / block);
  const std::size_t blocks_y = static_cast<std::size_t>(height_ / block);
  const auto inner_x = static_cast<std::size_t>((inner_width_ + block - 1) / block);
  const auto inner_y = static_cast<std::size_t>((inner_height_ + block - 1) / block);
  // Where the row of block values of a point begins for the first row of poses.
  std::vector<const std::uint8_t*> sources;
  const auto add_sources = [&](const Pyramid& pyramid, std::span<const CellOffset> offsets) {
    for (const CellOffset offset : offsets) {
      const int x = kBorder + offset.x;
      const int y = kBorder + offset.y;
      const int phase_index = (y % block) * block + x % block;
      const auto phase = static_cast<std::size_t>(phase_index);
      const auto row = phase * blocks_y + static_cast<std::size_t>(y / block);
      sources.push_back(
          &pyramid.top_by_phase[row * blocks_x + static_cast<std::size_t>(x / block)]);
    }
  };
  const std::vector<std::uint8_t> nothing(blocks_x * blocks_y, 0);
  std::vector<std::uint16_t> sums(inner_x);
  for (std::size_t rotation = 0; rotation < kRotations; ++rotation) {
    sources.clear();
    add_sources(ends_, query.ends(rotation));
    add_sources(way_, query.way(rotation));
    while (sources.size() % kGroup != 0) sources.push_back(nothing.data());
    for (std::size_t row = 0; row < inner_y; ++row) {
      std::fill(sums.begin(), sums.end(), std::uint16_t{0});
      for (std::size_t group = 0; group < sources.size(); group += kGroup) {
        add_group(std::span<const std::uint8_t*, kGroup>(&sources[group], kGroup), row * blocks_x,
                  sums);
      }
      for (std::size_t column = 0; column < inner_x; ++column) {
        if (sums[column] < query.threshold) continue;
        open.push_back(
            {sums[column], static_cast<std::int16_t>(kBorder + static_cast<int>(column) * block),
             static_cast<std::int16_t>(kBorder + static_cast<int>(row) * block),
             static_cast<std::uint8_t>(rotation), static_cast<std::uint8_t>(top_level_)});
      }
    }
  }
}

std::vector<Place> PlaceSearch::find(std::span<const Point2> ends_base_link,
                                     std::span<const Point2> way_base_link,
                                     const PlaceSearchParams& params) const {
  std::vector<Place> places;
  if (ends_base_link.empty() || inner_width_ == 0 || inner_height_ == 0) return places;
  std::vector<Point2> ends = thinned(ends_base_link, static_cast<std::size_t>(params.max_points));
  std::vector<Point2> way = thinned(way_base_link, kMaxWayPoints);
  Query query;
  query.center_base_link = mean(ends);
  const double reach = (kBorder - 2) * cell_m_;
  const auto too_far = [&](const Point2& p) { return (p - query.center_base_link).norm() > reach; };
  std::erase_if(ends, too_far);
  std::erase_if(way, too_far);
  if (ends.empty()) return places;
  query.end_count = ends.size();
  query.way_count = way.size();
  const double step = 2.0 * std::numbers::pi / kRotations;
  for (int rotation = 0; rotation < kRotations; ++rotation) {
    append_offsets(query.end_offsets, ends, query.center_base_link, rotation * step, cell_m_);
    append_offsets(query.way_offsets, way, query.center_base_link, rotation * step, cell_m_);
  }
  const double end_count = static_cast<double>(query.end_count);
  const double way_part = static_cast<double>(kWayFree) * static_cast<double>(query.way_count);
  query.threshold = static_cast<int>(
      (params.min_mean_weight - kLowestWeight) * kStepsPerNat * end_count + way_part);

  std::vector<Node> open;
  search_top(query, open);
  std::make_heap(open.begin(), open.end());
  const auto pose_of = [&](double x, double y,
                           int rotation) {  // of base_link in `grid`, centre at cells x, y
    const Pose2 T_grid_center{(x - kBorder) * cell_m_, (y - kBorder) * cell_m_,
                              wrap_angle(rotation * step)};
    return T_grid_center * Pose2{-query.center_base_link.x(), -query.center_base_link.y(), 0.0};
  };
  std::vector<Pose2> found;  // in `grid`
  const auto is_known = [&](const Node& node) {
    const double half = 0.5 * (1 << node.level);
    const Pose2 middle = pose_of(node.x + half, node.y + half, node.rotation);
    const double slack = std::numbers::sqrt2 * (half - 0.5) * cell_m_;
    return std::any_of(found.begin(), found.end(), [&](const Pose2& place) {
      return distance(place, middle) + slack < params.distinct_distance_m &&
             angle_between(place, middle) < params.distinct_angle_rad;
    });
  };
  for (std::size_t expansions = 0; !open.empty() && expansions < params.max_expansions;
       ++expansions) {
    std::pop_heap(open.begin(), open.end());
    const Node node = open.back();
    open.pop_back();
    if (is_known(node)) continue;
    if (node.level == 0) {
      found.push_back(pose_of(node.x + 0.5, node.y + 0.5, node.rotation));
      places.push_back({T_map_grid_ * found.back(),
                        (node.bound - way_part) / (kStepsPerNat * end_count) + kLowestWeight});
      if (places.size() == params.max_places) break;
      if (places.size() == 1)
        query.threshold =
            std::max(query.threshold,
                     node.bound - static_cast<int>(params.max_mean_gap * kStepsPerNat * end_count));
      continue;
    }
    const int half = 1 << (node.level - 1);
    for (int child = 0; child < 4; ++child) {
      Node next = node;
      next.level = static_cast<std::uint8_t>(node.level - 1);
      next.x = static_cast<std::int16_t>(node.x + (child % 2) * half);
      next.y = static_cast<std::int16_t>(node.y + (child / 2) * half);
      if (next.x >= kBorder + inner_width_ || next.y >= kBorder + inner_height_) continue;
      next.bound = bound(query, next);
      if (next.bound < query.threshold) continue;
      open.push_back(next);
      std::push_heap(open.begin(), open.end());
    }
  }
  return places;
}

}  // namespace cornerfix
