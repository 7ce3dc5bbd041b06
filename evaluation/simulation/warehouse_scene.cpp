#include <algorithm>

#include "evaluation/simulation/scene_kinds.hpp"

namespace cornerfix::evaluation {

namespace {

/// Racks run along `v`, aisles are stepped along `u`: the axes of the plan, or swapped.
struct RackPlan {
  double aisle_m = 3.0;
  double depth_m = 1.1;
  double bay_m = 2.8;
  double upright_m = 0.1;
  int pallets_per_bay = 2;
  double fill = 0.8;      ///< Share of the pallet places that are taken.
  double block_m = 30.0;  ///< Length of a rack without a cross aisle.
  double cross_aisle_m = 4.0;
  double missing = 0.05;     ///< Share of the blocks that were never built.
  bool double_racks = true;  ///< Back to back.
  bool swapped = false;
};

RackPlan rack_plan(SeededRandom& layout) {
  RackPlan plan;
  plan.aisle_m = layout.uniform(2.5, 3.8);
  plan.depth_m = layout.uniform(0.9, 1.25);
  plan.bay_m = layout.uniform(1.9, 3.7);
  plan.upright_m = layout.uniform(0.08, 0.14);
  plan.pallets_per_bay = plan.bay_m > 2.9 ? 3 : 2;
  plan.fill = layout.uniform(0.5, 0.92);
  plan.block_m = layout.uniform(15.0, 42.0);
  plan.cross_aisle_m = layout.uniform(3.0, 5.5);
  plan.missing = layout.uniform(0.0, 0.12);
  plan.double_racks = layout.chance(0.7);
  plan.swapped = layout.chance(0.5);
  return plan;
}

class Warehouse {
 public:
  explicit Warehouse(SceneSeeds& seeds)
      : seeds_(seeds),
        racks_(rack_plan(seeds_.layout)),
        canvas_(seeds_.canvas({60.0, 45.0}, {120.0, 90.0}, Cell::kFree)) {}

  OccupancyGrid draw() {
    draw_hall();
    draw_office();
    draw_columns();
    draw_racks();
    draw_floor_stock();
    return canvas_.take();
  }

 private:
  void draw_hall() {
    const double thickness = seeds_.layout.uniform(0.2, 0.5);
    const PlanArea hall = PlanArea{Point2::Zero(), canvas_.size()}.inset(0.5 * thickness);
    canvas_.room(hall, thickness);
    const double pitch = seeds_.layout.uniform(4.0, 8.0);
    const double pillar = seeds_.layout.uniform(0.3, 0.7);
    const double first = seeds_.layout.uniform(3.0, 8.0);
    for (double x = first; x < canvas_.size().x() - 4.0; x += pitch)  // dock pillars
      canvas_.box({x, thickness + 0.5 * pillar, 0.0}, {0.4, pillar});
  }

  void draw_office() {
    SeededRandom& layout = seeds_.layout;
    const Point2 size{layout.uniform(8.0, 18.0), layout.uniform(5.0, 12.0)};
    const Point2 low = canvas_.size() - size;
    office_ = {low - Point2::Constant(2.0), canvas_.size()};
    const PlanArea office{low, canvas_.size()};
    canvas_.room(office, 0.15);
    const double door_y = layout.uniform(low.y() + 0.8, canvas_.size().y() - 2.0);
    canvas_.box({low.x(), door_y, 0.0}, {0.4, 1.2}, Cell::kFree);
    const double middle = low.x() + size.x() * layout.uniform(0.35, 0.65);
    canvas_.wall({middle, low.y()}, {middle, canvas_.size().y()}, 0.1);
    canvas_.box({middle, low.y() + size.y() * layout.uniform(0.25, 0.6), 0.0}, {0.3, 1.0},
                Cell::kFree);
  }

  void draw_columns() {
    SeededRandom& layout = seeds_.layout;
    const Point2 pitch{layout.uniform(8.0, 16.0), layout.uniform(10.0, 24.0)};
    const double side = layout.uniform(0.3, 0.6);
    for (double x = pitch.x(); x < canvas_.size().x() - 4.0; x += pitch.x()) {
      for (double y = pitch.y(); y < canvas_.size().y() - 4.0; y += pitch.y())
        canvas_.box({x, y, 0.0}, {side, side});
    }
  }

  /// From the plane of the racks to that of the plan.
  [[nodiscard]] Point2 plan(double u, double v) const {
    return racks_.swapped ? Point2{v, u} : Point2{u, v};
  }

  void draw_racks() {
    SeededRandom& layout = seeds_.layout;
    const Point2 extent = plan(canvas_.size().x(), canvas_.size().y());
    const double margin_u = layout.uniform(4.0, 8.0);
    const double margin_v = layout.uniform(6.0, 14.0);
    const double row_m = racks_.depth_m * (racks_.double_racks ? 2.0 : 1.0) + racks_.aisle_m;
    for (double u = margin_u; u < extent.x() - margin_u; u += row_m) {
      for (double v = margin_v; v + racks_.bay_m < extent.y() - 5.0;
           v += racks_.block_m + racks_.cross_aisle_m) {
        const double length = std::min(racks_.block_m, extent.y() - 5.0 - v);
        const bool is_missing = layout.chance(racks_.missing);
        draw_block(u, v, length, is_missing);
      }
    }
  }

  void draw_block(double u, double v, double length, bool is_missing) {
    const int bays = static_cast<int>(length / racks_.bay_m);
    for (int side = 0; side < (racks_.double_racks ? 2 : 1); ++side) {
      for (int bay = 0; bay <= bays; ++bay) {
        const Point2 corner{u + side * racks_.depth_m, v + bay * racks_.bay_m};
        if (is_missing || is_in_office(corner)) continue;
        draw_upright(corner);
        if (bay < bays) draw_pallets(corner);
      }
    }
  }

  [[nodiscard]] bool is_in_office(const Point2& corner) const {
    const Point2 near = plan(corner.x(), corner.y());
    const Point2 far = plan(corner.x() + racks_.depth_m, corner.y() + racks_.bay_m);
    return far.x() > office_.low.x() && far.y() > office_.low.y() && near.x() < office_.high.x();
  }

  /// Two posts: one at the aisle, one at the back.
  void draw_upright(const Point2& corner) {
    const double half = 0.5 * racks_.upright_m;
    for (const double offset : {half, racks_.depth_m - half}) {
      const Point2 at = plan(corner.x() + offset, corner.y());
      canvas_.box({at.x(), at.y(), 0.0}, Point2::Constant(racks_.upright_m));
    }
  }

  void draw_pallets(const Point2& corner) {
    SeededRandom& change = seeds_.change;
    const double pitch = (racks_.bay_m - racks_.upright_m) / racks_.pallets_per_bay;
    for (int i = 0; i < racks_.pallets_per_bay; ++i) {
      const bool is_taken = change.chance(racks_.fill);
      const double width = change.uniform(0.7, 0.95) * pitch;
      const double depth = change.uniform(0.75, 1.0) * racks_.depth_m;
      const double shift = change.uniform(-0.08, 0.08);
      if (!is_taken) continue;
      const Point2 at = plan(corner.x() + 0.5 * racks_.depth_m + shift,
                             corner.y() + 0.5 * racks_.upright_m + (i + 0.5) * pitch + shift);
      canvas_.box({at.x(), at.y(), change.uniform(-0.04, 0.04)}, plan(depth, width));
    }
  }

  /// Pallets on the floor and trucks, along the docks.
  void draw_floor_stock() {
    SeededRandom& change = seeds_.change;
    const int count = change.integer(3, 14);
    for (int i = 0; i < count; ++i) {
      const Point2 at{change.uniform(4.0, canvas_.size().x() - 4.0), change.uniform(2.0, 3.5)};
      const double yaw = change.uniform(-0.3, 0.3);
      const Point2 size{change.uniform(0.8, 2.4), change.uniform(0.8, 1.4)};
      canvas_.box({at.x(), at.y(), yaw}, size);
    }
  }

  SceneSeeds& seeds_;
  RackPlan racks_;
  SceneCanvas canvas_;
  PlanArea office_;
};

}  // namespace

OccupancyGrid warehouse_scene(SceneSeeds& seeds) { return Warehouse(seeds).draw(); }

}  // namespace cornerfix::evaluation
