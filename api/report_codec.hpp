/// \file  The localizability report as a document, and as a picture.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include <cornerfix/localizability.hpp>

#include "api/json_codec.hpp"

namespace cornerfix::api {

/// The map that a report is of.
struct ReportOrigin {
  std::string_view map;
  std::uint64_t revision = 0;
};

[[nodiscard]] Json render_report(const ReportOrigin& origin, const LocalizabilityReport& report);
/// While it is being made. \param share  Of the work that is done, in [0, 1].
[[nodiscard]] Json render_report_progress(const ReportOrigin& origin, double share);

/// An SVG: the grid, each place in a colour by how far robots drive from it, and lines between
/// places that look alike.
[[nodiscard]] std::string draw_report(const LocalizabilityReport& report,
                                      const OccupancyGrid& grid);

}  // namespace cornerfix::api
