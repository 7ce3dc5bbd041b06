#include <cornerfix/localizability.hpp>

#include <algorithm>

namespace cornerfix {
namespace {

constexpr double kHardWay = 3.0;        // of a place [m]
constexpr double kEasyWay = 0.5;        // [m]
constexpr double kNeighbourhood = 1.6;  // of places, in spacings of the lattice

double way_at(const LocalizabilityReport& report, std::size_t place) {
  return expected_way_m(report.places[place], report.way_limit_m);
}

/// Groups of places with low localizability, each near another one of its group.
std::vector<std::vector<std::size_t>> group_hard_places(const LocalizabilityReport& report) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < report.places.size(); ++i) {
    if (way_at(report, i) >= kHardWay) left.push_back(i);
  }
  std::vector<std::vector<std::size_t>> groups;
  while (!left.empty()) {
    std::vector<std::size_t> group{left.front()};
    left.erase(left.begin());
    for (std::size_t k = 0; k < group.size(); ++k) {
      const Point2 here = report.places[group[k]].position_map;
      const auto is_near = [&](std::size_t other) {
        return (report.places[other].position_map - here).norm() <=
               kNeighbourhood * report.lattice_m;
      };
      std::ranges::copy_if(left, std::back_inserter(group), is_near);
      std::erase_if(left, is_near);
    }
    std::ranges::sort(group);
    groups.push_back(std::move(group));
  }
  return groups;
}

std::optional<Point2> nearest_easy_place(const LocalizabilityReport& report, const Point2& from) {
  std::optional<Point2> nearest;
  for (std::size_t i = 0; i < report.places.size(); ++i) {
    const Point2& position = report.places[i].position_map;
    if (way_at(report, i) > kEasyWay) continue;
    if (!nearest || (position - from).norm() < (*nearest - from).norm()) nearest = position;
  }
  return nearest;
}

LowLocalizabilityRegion describe_area(const LocalizabilityReport& report,
                                      std::vector<std::size_t> places) {
  LowLocalizabilityRegion area;
  std::size_t starts = 0;
  std::size_t found = 0;
  std::size_t confused = 0;
  const AssessedStart* longest_confused = nullptr;
  for (const std::size_t i : places) {
    const AssessedPlace& place = report.places[i];
    area.center_map += place.position_map / static_cast<double>(places.size());
    area.way_m += way_at(report, i) / static_cast<double>(places.size());
    for (const AssessedStart& start : place.starts) {
      ++starts;
      found += start.way_m ? 1 : 0;
      if (!start.rival) continue;
      ++confused;
      if (longest_confused == nullptr || start.rival_way_m > longest_confused->rival_way_m)
        longest_confused = &start;
    }
  }
  for (const std::size_t i : places) {
    area.radius_m =
        std::max(area.radius_m, (report.places[i].position_map - area.center_map).norm());
  }
  area.found = static_cast<double>(found) / static_cast<double>(starts);
  if (2 * confused >= starts) area.look_alike_map = longest_confused->rival->translation();
  area.easy_map = nearest_easy_place(report, area.center_map);
  area.places = std::move(places);
  return area;
}

}  // namespace

std::vector<LowLocalizabilityRegion> find_low_localizability_regions(
    const LocalizabilityReport& report) {
  std::vector<LowLocalizabilityRegion> areas;
  for (auto& group : group_hard_places(report))
    areas.push_back(describe_area(report, std::move(group)));
  std::ranges::stable_sort(areas, std::greater{}, [](const LowLocalizabilityRegion& area) {
    return area.way_m * static_cast<double>(area.places.size());
  });
  return areas;
}

}  // namespace cornerfix
