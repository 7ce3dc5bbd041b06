// Any bytes are an archive of a map, or none. Reading them must end, in bounds and in little
// memory, and what comes out has the digest that it states.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "storage/map_archive.hpp"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto archive = cornerfix::storage::decode_archive(std::span(data, size));
  if (!archive) {
    require(!archive.error().message.empty() && archive.error().field == "archive");
    return 0;
  }
  const auto bytes = cornerfix::storage::encode_archive(*archive);
  require(static_cast<bool>(bytes));
  const auto again = cornerfix::storage::decode_archive(*bytes);
  require(again && again->digest == archive->digest);
  return 0;
}
