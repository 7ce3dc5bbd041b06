/// \file  The localizability report in sentences for those who run the robots.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <cornerfix/localizability.hpp>

namespace cornerfix::api {

/// Shares of the simulated starts that were localized.
struct ReportShares {
  std::size_t starts = 0;
  double found_at_once = 0.0;
  double found = 0.0;     ///< Within the way allowed.
  std::size_t wrong = 0;  ///< Starts whose first pose was wrong.
};
[[nodiscard]] ReportShares shares_of(const LocalizabilityReport& report);

/// One sentence.
[[nodiscard]] std::string summarize(const LocalizabilityReport& report);
/// What to do, most important first; never empty.
[[nodiscard]] std::vector<std::string> advise(const LocalizabilityReport& report,
                                              std::span<const LowLocalizabilityRegion> areas);

[[nodiscard]] double features_per_100_m2(const LocalizabilityReport& report);

}  // namespace cornerfix::api
