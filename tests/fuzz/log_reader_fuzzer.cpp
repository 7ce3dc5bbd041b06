// Any bytes are a log, or no log, of any kind: the first bytes decide.
// Reading them must end, in bounds and in little memory, and what comes out must be scans.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "evaluation/datasets/log_reader.hpp"

namespace {

using cornerfix::evaluation::LogReader;

/// The readers take files; one in memory, for this process alone.
const std::filesystem::path& input_file() {
  static const std::filesystem::path path = "/dev/shm/cornerfix-fuzz-" + std::to_string(getpid());
  return path;
}

void require(bool condition) {
  if (!condition) std::abort();
}

void read_scans(LogReader& reader) {
  double last_stamp = -std::numeric_limits<double>::infinity();
  while (const auto scan = reader.next()) {
    require(scan->scan.ranges.size() == reader.header().beams);
    require(!cornerfix::validate(scan->scan));
    require(scan->scan.stamp > last_stamp);
    last_stamp = scan->scan.stamp;
  }
  require(reader.faults().first().size() <= reader.faults().count());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::ofstream(input_file(), std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  auto reader = LogReader::open(input_file());
  if (reader) {
    read_scans(*reader);
  } else {
    require(!reader.error().message.empty());
  }
  std::filesystem::remove(input_file());
  return 0;
}
