// Writes small archives into a directory, for the fuzzer to begin with.
#include <filesystem>
#include <fstream>
#include <string>

#include "storage/digest.hpp"
#include "storage/map_archive.hpp"

namespace {

using namespace cornerfix;

bool write(const std::filesystem::path& path, const storage::MapArchive& archive) {
  const auto bytes = storage::encode_archive(archive);
  if (!bytes) return false;
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes->data()),
             static_cast<std::streamsize>(bytes->size()));
  return static_cast<bool>(file.flush());
}

storage::MapArchive archive_of_scans() {
  storage::MapArchive archive;
  const LaserScan scan{1.0, -1.0, 0.5, 0.1, 20.0, {1.0F, 2.0F, 3.0F}};
  archive.key_frames = {{scan, Pose2{}, Pose2{1.0, 2.0, 0.5}}};
  archive.stamps = {1.0};
  const storage::Blob blob = storage::encode_key_frame(archive.key_frames[0]);
  archive.digest = storage::map_digest("", storage::extend({}, blob));
  return archive;
}

storage::MapArchive archive_of_a_floor_map() {
  storage::MapArchive archive;
  OccupancyGrid grid;
  grid.width = grid.height = 2;
  grid.cells = {Cell::kFree, Cell::kOccupied, Cell::kUnknown, Cell::kFree};
  archive.digest = storage::map_digest("", storage::hash_of(grid));
  archive.floor_map = grid;
  return archive;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path directory = argv[1];
  const bool written = write(directory / "scans.cornerfix", archive_of_scans()) &&
                       write(directory / "floor_map.cornerfix", archive_of_a_floor_map());
  return written ? 0 : 1;
}
