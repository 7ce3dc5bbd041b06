/// \file  Processor time: what a computation costs, independent of what else the machine does.
#pragma once

#include <ctime>

namespace cornerfix::evaluation {

/// Milliseconds by one of the clocks of clock_gettime().
[[nodiscard]] inline double processor_ms(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Of this thread.
[[nodiscard]] inline double thread_ms() { return processor_ms(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace cornerfix::evaluation
