// A yaml, a zero byte, an image: any bytes are an occupancy map, or none. Reading them must end, in
// bounds and in little memory; what is read can be written and read again.
#include <cornerfix/map_image.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>

namespace {

constexpr cornerfix::MapImageLimits kLimits{.max_cells = 1'000'000};

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::string_view yaml = input.substr(0, input.find('\0'));
  const std::string_view image = input.substr(std::min(size, yaml.size() + 1));
  const auto bytes = std::as_bytes(std::span(image.data(), image.size()));
  const auto grid = cornerfix::parse_map(yaml, bytes, kLimits);
  if (!grid) {
    require(!grid.error().message.empty());
    return 0;
  }
  require(grid->cells.size() ==
          static_cast<std::size_t>(grid->width) * static_cast<std::size_t>(grid->height));
  const auto again = cornerfix::parse_map(cornerfix::encode_grid_yaml(*grid, "map.png"),
                                          cornerfix::encode_grid_png(*grid), kLimits);
  require(again && *again == *grid);
  return 0;
}
