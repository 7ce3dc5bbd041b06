#include "api/report_advice.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "api/format.hpp"

namespace cornerfix::api {
namespace {

constexpr std::size_t kMaxAreasTold = 5;
constexpr double kFewFeatures = 2.0;  // in 100 m2

std::string at(const Point2& point) { return format("(%.1f, %.1f)", point.x(), point.y()); }

std::string percent(double share) { return format("%.0f %%", 100.0 * share); }

/// "in the north-east", by thirds of the box around all places.
std::string part_of_map(const LocalizabilityReport& report, const Point2& point) {
  Point2 low = report.places.front().position_map;
  Point2 high = low;
  for (const AssessedPlace& place : report.places) {
    low = low.cwiseMin(place.position_map);
    high = high.cwiseMax(place.position_map);
  }
  const auto third = [&](int axis) {
    const double share = (point[axis] - low[axis]) / std::max(1e-9, high[axis] - low[axis]);
    return share < 1.0 / 3.0 ? 0 : (share > 2.0 / 3.0 ? 2 : 1);
  };
  static constexpr const char* kNames[3][3] = {{"south-west", "south", "south-east"},
                                               {"west", "middle", "east"},
                                               {"north-west", "north", "north-east"}};
  return std::string("in the ") + kNames[third(1)][third(0)];
}

std::string cause(const LowLocalizabilityRegion& area) {
  if (area.look_alike_map) return "it looks like the place around " + at(*area.look_alike_map);
  return "too little is seen there to tell it from other places";
}

std::string remedy(const LowLocalizabilityRegion& area) {
  std::string change = area.look_alike_map
                           ? "put something that stays and stands out at one of the two"
                           : "let them drive on, or give them a lidar that sees farther or wider";
  if (!area.easy_map) return change;
  return format("switch them on nearer to %s, %.1f m away, or ", at(*area.easy_map).c_str(),
                (*area.easy_map - area.center_map).norm()) +
         change;
}

std::string advice_for(const LocalizabilityReport& report, const LowLocalizabilityRegion& area) {
  std::string text = "Robots switched on " + part_of_map(report, area.center_map) + ", around " +
                     at(area.center_map);
  if (area.radius_m > 0.0) text += format(" and up to %.1f m from there", area.radius_m);
  text += format(", need %.0f m", area.way_m);
  if (area.found < 1.0) {
    text += format(" and more, %s of them more than %.0f m", percent(1.0 - area.found).c_str(),
                   report.way_limit_m);
  }
  return text + ": " + cause(area) + ". Better " + remedy(area) + ".";
}

}  // namespace

ReportShares shares_of(const LocalizabilityReport& report) {
  ReportShares shares;
  double at_once = 0.0;
  double found = 0.0;
  for (const AssessedPlace& place : report.places) {
    for (const AssessedStart& start : place.starts) {
      ++shares.starts;
      shares.wrong += start.is_wrong ? 1 : 0;
      if (!start.way_m) continue;
      found += 1.0;
      at_once += *start.way_m == 0.0 ? 1.0 : 0.0;
    }
  }
  const auto all = static_cast<double>(std::max<std::size_t>(1, shares.starts));
  shares.found = found / all;
  shares.found_at_once = at_once / all;
  return shares;
}

double features_per_100_m2(const LocalizabilityReport& report) {
  if (report.free_area_m2 == 0.0) return 0.0;
  return 100.0 * static_cast<double>(report.features) / report.free_area_m2;
}

std::string summarize(const LocalizabilityReport& report) {
  if (report.places.empty())
    return "The map has no free space in which a robot could be switched on.";
  const ReportShares shares = shares_of(report);
  return format(
      "Of %zu robots, four at each of %zu places, %s are told their pose before they "
      "drive and %s within %.0f m.",
      shares.starts, report.places.size(), percent(shares.found_at_once).c_str(),
      percent(shares.found).c_str(), report.way_limit_m);
}

std::vector<std::string> advise(const LocalizabilityReport& report,
                                std::span<const LowLocalizabilityRegion> areas) {
  std::vector<std::string> advice;
  if (report.places.empty()) {
    advice.emplace_back("Map the building, or give the map a floor map with free cells.");
    return advice;
  }
  if (const std::size_t wrong = shares_of(report).wrong; wrong > 0) {
    advice.push_back(
        format("%zu of the robots were told a wrong pose first: do not rely on the "
               "first fix near places that look alike.",
               wrong));
  }
  for (const LowLocalizabilityRegion& area : areas.first(std::min(areas.size(), kMaxAreasTold)))
    advice.push_back(advice_for(report, area));
  if (areas.empty()) {
    advice.emplace_back("Robots may be switched on anywhere: from no place they need 3 m or more.");
  }
  if (const double density = features_per_100_m2(report); density < kFewFeatures) {
    advice.push_back(
        format("The map shows %.1f corners in 100 m2: the methods rma and nma, which "
               "match corners, will find little in it.",
               density));
  }
  return advice;
}

}  // namespace cornerfix::api
