/// \file  Which scans of a log make the map and which ask, in an evaluation.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "evaluation/datasets/log_reader.hpp"

namespace cornerfix::evaluation {

/// The first share of the posed scans maps, the rest asks; in [0, 1].
struct ShareSplit {
  double share = 0.5;
};

/// Blocks of path length take turns, a mapping one first; > 0.
struct BlockSplit {
  double block_m = 30.0;
};

using LogSplit = std::variant<ShareSplit, BlockSplit>;

/// "0.5" or "blocks:30"; nothing for anything else.
[[nodiscard]] std::optional<LogSplit> parse_log_split(std::string_view text);

/// Ascending indices of posed scans.
struct DividedLog {
  std::vector<std::size_t> mapping;
  std::vector<std::size_t> asking;
};

[[nodiscard]] DividedLog divide(const RecordedLog& log, const LogSplit& split);

/// The scans with a reference pose from `begin` on, and before `end`.
[[nodiscard]] std::vector<std::size_t> posed_scans(const RecordedLog& log, std::size_t begin,
                                                   std::size_t end);

}  // namespace cornerfix::evaluation
