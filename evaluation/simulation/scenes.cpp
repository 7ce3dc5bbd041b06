#include "evaluation/simulation/scenes.hpp"

#include <algorithm>
#include <array>

#include "evaluation/simulation/scene_kinds.hpp"

namespace cornerfix::evaluation {

namespace {

struct NamedScene {
  SceneKind kind;
  std::string_view name;
  OccupancyGrid (*make)(SceneSeeds&);
};

constexpr std::array<NamedScene, 7> kScenes{{{SceneKind::kWarehouse, "warehouse", warehouse_scene},
                                             {SceneKind::kYard, "yard", yard_scene},
                                             {SceneKind::kCorridors, "corridors", corridors_scene},
                                             {SceneKind::kOffice, "office", office_scene},
                                             {SceneKind::kHome, "home", home_scene},
                                             {SceneKind::kHall, "hall", hall_scene},
                                             {SceneKind::kGlass, "glass", glass_scene}}};

const NamedScene& scene_of(SceneKind kind) {
  return *std::ranges::find(kScenes, kind, &NamedScene::kind);
}

}  // namespace

void draw_landmarks(SceneCanvas& canvas, SeededRandom& layout, const PlanArea& area,
                    double metres_each) {
  const int count = static_cast<int>(area.size().x() / metres_each);
  for (int i = 0; i < count; ++i) {
    const bool at_low_side = layout.chance(0.5);
    const Point2 size{layout.uniform(0.2, 1.2), layout.uniform(0.15, 0.4)};
    const Point2 at{layout.uniform(area.low.x() + 1.0, area.high.x() - 1.0),
                    at_low_side ? area.low.y() + 0.5 * size.y() : area.high.y() - 0.5 * size.y()};
    canvas.box({at.x(), at.y(), 0.0}, size);
  }
}

std::optional<SceneKind> scene_kind_from_string(std::string_view name) {
  const auto found = std::ranges::find(kScenes, name, &NamedScene::name);
  if (found == kScenes.end()) return std::nullopt;
  return found->kind;
}

std::string_view to_string(SceneKind kind) { return scene_of(kind).name; }

const std::vector<SceneKind>& all_scene_kinds() {
  static const std::vector<SceneKind> kinds = [] {
    std::vector<SceneKind> all;
    all.reserve(kScenes.size());
    for (const NamedScene& scene : kScenes) all.push_back(scene.kind);
    return all;
  }();
  return kinds;
}

std::vector<std::string> scene_kind_names() {
  std::vector<std::string> names;
  for (const SceneKind kind : all_scene_kinds()) names.emplace_back(to_string(kind));
  return names;
}

OccupancyGrid make_scene(SceneKind kind, std::uint64_t layout_seed, std::uint64_t change_seed) {
  const auto stream = static_cast<std::uint32_t>(kind);
  // The change depends on the layout seed as well, or all layouts would change alike.
  const std::uint64_t change = change_seed * 0x9e3779b97f4a7c15ULL + layout_seed;
  SceneSeeds seeds{SeededRandom(layout_seed, stream), SeededRandom(change, 100 + stream)};
  return scene_of(kind).make(seeds);
}

}  // namespace cornerfix::evaluation
