// Writes bodies of calls in each format into a directory, for the fuzzer to begin with.
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "api/json_codec.hpp"
#include "support/binary_text.hpp"

namespace {

using namespace cornerfix::api;

const char* const kScan =
    R"({"stamp": 1.5, "ranges": [1, null, 2.5], "odom": {"x": 0.1, "y": 0, "yaw": -0.5}})";
const char* const kRosScan =
    R"({"header": {"stamp": {"secs": 2, "nsecs": 500}, "frame_id": "laser", "seq": 1},
        "angle_min": -1, "angle_max": 1, "angle_increment": 0.5, "time_increment": 0.001,
        "scan_time": 0.1, "range_min": 0.1, "range_max": null, "ranges": [1, 2, 3, 4, 5],
        "intensities": [], "odom": {"pose": {"pose": {"position": {"x": 1, "y": 2, "z": 0},
        "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}}}})";
const char* const kLidar =
    R"({"angle_min": -1.5, "angle_increment": 0.1, "range_min": 0.05, "range_max": 30, "beams": 3,
        "mount": {"x": 0.2, "y": 0, "yaw": 3.1}, "time_increment": 1e-4})";

/// One body per call, in the order of the fuzzer.
std::array<std::string, 6> bodies() {
  const std::string scans = std::string("[") + kScan + "," + kRosScan + "]";
  const std::string lidar = std::string(R"("lidar": )") + kLidar;
  const std::string pose = R"({"stamp": 1, "pose": {"x": 1, "y": 2, "yaw": 3}})";
  return {R"({"sequence": 7, "scans": )" + scans + "}",
          "{" + lidar + R"(, "scans": [{"stamp": 1, "ranges": [1, 2, 3], "pose":
            {"x": 1, "y": 2, "yaw": 3}}]})",
          "{" + lidar + R"(, "scans": )" + scans + R"(, "options": {"seed": 3}})",
          R"({"robot": "cart-7", "maps": ["a", "b"], )" + lidar +
              R"(, "options": {"method": "rma", "sampling": {"overlap": 0.5}}})",
          R"({"description": "Second floor", )" + lidar +
              R"(, "parameters": {"min_feature_count": 2, "grid": {"resolution_m": 0.05}}})",
          R"({"poses": [)" + pose + "]}"};
}

/// A session's batch of float32 ranges; each scan has odometry where `flags` is 1.
std::string binary_batch(std::uint32_t flags) {
  const auto header = binary_header({.flags = flags, .sequence = 7, .scans = 2, .beams = 3});
  const std::string odometry = flags == 1 ? binary_text(0.1, 0.0, -0.5) : "";
  const std::string rest = odometry + binary_text(1.0F, 2.0F, 2.5F);
  return header + binary_text(1.5) + rest + binary_text(2.5) + rest;
}

/// Into a file of a name of its own, behind the byte that selects call and format.
bool write(const std::filesystem::path& directory, const std::string& name, std::size_t call,
           BodyFormat format, const std::string& body) {
  std::ofstream file(directory / name, std::ios::binary);
  const auto selector = static_cast<char>(4 * call + static_cast<std::size_t>(format));
  return static_cast<bool>((file << selector << body).flush());
}

bool write_all(const std::filesystem::path& directory) {
  const auto texts = bodies();
  bool good = true;
  for (std::size_t call = 0; call < texts.size(); ++call) {
    const Json body = Json::parse(texts[call]);
    for (const auto format : {BodyFormat::kJson, BodyFormat::kCbor, BodyFormat::kMessagePack}) {
      const auto name =
          "body_" + std::to_string(call) + "_" + std::to_string(static_cast<int>(format));
      good &= write(directory, name, call, format, encode(body, format));
    }
  }
  for (const std::uint32_t flags : {0U, 1U}) {
    const auto name = "binary_" + std::to_string(flags);
    good &= write(directory, name, 0, BodyFormat::kBinaryBatch, binary_batch(flags));
  }
  return good;
}

}  // namespace

int main(int argc, char** argv) { return argc == 2 && write_all(argv[1]) ? 0 : 1; }
