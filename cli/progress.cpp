#include "cli/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

namespace cornerfix::cli {

namespace {

constexpr int kBarWidth = 40;

}  // namespace

Progress::Progress(std::string label, std::FILE* stream, bool is_terminal)
    : label_(std::move(label)), stream_(stream), is_terminal_(is_terminal) {}

Progress::Progress(std::string label)
    : Progress(std::move(label), stderr, isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (is_terminal_ && last_percent_ >= 0) std::fputc('\n', stream_);
}

void Progress::update(double share) {
  const int step = is_terminal_ ? 1 : 10;
  const int percent = static_cast<int>(100.0 * std::clamp(share, 0.0, 1.0)) / step * step;
  if (percent <= last_percent_) return;
  last_percent_ = percent;
  if (is_terminal_) {
    const auto filled = static_cast<std::size_t>(percent * kBarWidth / 100);
    const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, ' ');
    std::fprintf(stream_, "\r%s [%s] %3d %%", label_.c_str(), bar.c_str(), percent);
  } else {
    std::fprintf(stream_, "%s: %d %%\n", label_.c_str(), percent);
  }
  std::fflush(stream_);
}

}  // namespace cornerfix::cli
