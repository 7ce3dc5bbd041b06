#include "evaluation/simulation/scene_files.hpp"

#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

#include <cornerfix/map_image.hpp>

namespace cornerfix::evaluation {

namespace {

Result<void> write_bytes(const std::filesystem::path& path, const char* bytes, std::size_t size) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes, static_cast<std::streamsize>(size));
  if (!file.flush()) return Error{ErrorCode::kStorageFull, "could not be written", path};
  return {};
}

}  // namespace

Result<void> write_scene(std::filesystem::path stem, const OccupancyGrid& scene) {
  if (stem.extension() == ".yaml") stem.replace_extension();
  const std::filesystem::path image = stem.string() + ".png";
  const std::vector<std::byte> png = encode_grid_png(scene);
  Result<void> written = write_bytes(image, reinterpret_cast<const char*>(png.data()), png.size());
  if (!written) return written;
  const std::string yaml = encode_grid_yaml(scene, image.filename().string());
  return write_bytes(stem.string() + ".yaml", yaml.data(), yaml.size());
}

}  // namespace cornerfix::evaluation
