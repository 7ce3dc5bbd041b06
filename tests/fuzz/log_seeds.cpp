// Writes a small bag of each kind into a directory, for a fuzzer to begin with.
#include <filesystem>
#include <fstream>

#include "unit/evaluation/datasets/bag/bag_writers.hpp"

namespace cornerfix::evaluation {
namespace {

std::vector<std::vector<WrittenMessage>> drive(WireFormat format) {
  const std::string infix = format == WireFormat::kCdr ? "/msg/" : "/";
  std::vector<std::vector<WrittenMessage>> chunks;
  for (int i = 0; i < 3; ++i) {
    const double stamp = 10.0 + i;
    chunks.push_back(
        {{stamp, "/tf", "tf2_msgs" + infix + "TFMessage",
          transforms(format, stamp,
                     {{"map", "odom", 1.0, 2.0, 0.5}, {"base_link", "laser", 0.2, 0.0, 0.0}})},
         {stamp, "/odom", "nav_msgs" + infix + "Odometry", odometry(format, stamp, i, 0.0, 0.1)},
         {stamp, "/scan", "sensor_msgs" + infix + "LaserScan",
          laser_scan(format, stamp, {1.0F, 2.0F, 3.0F})}});
  }
  return chunks;
}

void write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

void write_all(const std::filesystem::path& directory) {
  for (const std::string compression : {"none", "bz2", "lz4"}) {
    write(directory / ("ros1_" + compression), ros1_bag(drive(WireFormat::kRos1), compression));
  }
  for (const std::string compression : {"", "lz4", "zstd"}) {
    write(directory / ("mcap_" + compression), mcap(drive(WireFormat::kCdr), compression));
  }
  std::vector<WrittenMessage> messages;
  for (const auto& chunk : drive(WireFormat::kCdr)) {
    messages.insert(messages.end(), chunk.begin(), chunk.end());
  }
  std::filesystem::remove(directory / "sqlite");
  write_sqlite_bag(directory / "sqlite", messages);
}

}  // namespace
}  // namespace cornerfix::evaluation

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  cornerfix::evaluation::write_all(argv[1]);
  return 0;
}
