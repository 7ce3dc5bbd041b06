#include "evaluation/datasets/log_split.hpp"

#include <charconv>
#include <cmath>

namespace cornerfix::evaluation {

namespace {

std::optional<double> parse_number(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) {
    return std::nullopt;
  }
  return number;
}

DividedLog divide_by_share(const std::vector<std::size_t>& posed, double share) {
  const auto mapping = static_cast<std::ptrdiff_t>(static_cast<double>(posed.size()) * share);
  return {{posed.begin(), posed.begin() + mapping}, {posed.begin() + mapping, posed.end()}};
}

DividedLog divide_by_blocks(const RecordedLog& log, const std::vector<std::size_t>& posed,
                            double block_m) {
  DividedLog divided;
  double path_length_m = 0.0;
  for (std::size_t k = 0; k < posed.size(); ++k) {
    if (k > 0)
      path_length_m +=
          distance(*log.scans[posed[k - 1]].T_map_laser, *log.scans[posed[k]].T_map_laser);
    const bool maps = std::fmod(std::floor(path_length_m / block_m), 2.0) == 0.0;
    (maps ? divided.mapping : divided.asking).push_back(posed[k]);
  }
  return divided;
}

}  // namespace

std::optional<LogSplit> parse_log_split(std::string_view text) {
  constexpr std::string_view kBlocks = "blocks:";
  if (text.starts_with(kBlocks)) {
    const auto block_m = parse_number(text.substr(kBlocks.size()));
    if (!block_m || *block_m <= 0.0) return std::nullopt;
    return BlockSplit{*block_m};
  }
  const auto share = parse_number(text);
  if (!share || *share < 0.0 || *share > 1.0) return std::nullopt;
  return ShareSplit{*share};
}

DividedLog divide(const RecordedLog& log, const LogSplit& split) {
  const std::vector<std::size_t> posed = posed_scans(log, 0, log.scans.size());
  if (const auto* blocks = std::get_if<BlockSplit>(&split)) {
    return divide_by_blocks(log, posed, blocks->block_m);
  }
  return divide_by_share(posed, std::get<ShareSplit>(split).share);
}

std::vector<std::size_t> posed_scans(const RecordedLog& log, std::size_t begin, std::size_t end) {
  std::vector<std::size_t> posed;
  for (std::size_t i = begin; i < end; ++i) {
    if (log.scans[i].T_map_laser) posed.push_back(i);
  }
  return posed;
}

}  // namespace cornerfix::evaluation
