/// \file  Processor time of this thread: what work costs, independent of other load.
#pragma once

#include <ctime>

namespace cornerfix::bench {

[[nodiscard]] inline double thread_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

}  // namespace cornerfix::bench
